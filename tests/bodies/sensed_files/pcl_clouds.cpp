// Clouds that PCL writes, and the points that it reads from any cloud.
//
// In: `make FOLDER`, or `list FILE`. Out: .pcd files in all three encodings and .ply files, or on standard output x, y
// and z of every point, as hexadecimal floats. README.md has the commands.

#include <pcl/conversions.h>
#include <pcl/io/pcd_io.h>
#include <pcl/io/ply_io.h>
#include <pcl/point_types.h>

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <limits>
#include <string>

namespace {

// A wavy sheet as an organised cloud, with holes where a sensor has no return; packing finds repetitions in its
// colours.
template <class Point, class Paint>
pcl::PCLPointCloud2 sheet(uint32_t width, uint32_t height, bool holes, Paint paint) {
  pcl::PointCloud<Point> cloud(width, height);
  for (uint32_t row = 0; row < height; ++row) {
    for (uint32_t column = 0; column < width; ++column) {
      Point& point = cloud.at(column, row);
      point.x = 0.1F * static_cast<float>(column) - 0.35F;
      point.y = 0.2F * static_cast<float>(row);
      point.z = 1.0F + std::sin(static_cast<float>(column * row)) / 3.0F;
      paint(point);
      if (holes && (column + 3 * row) % 5 == 0) point.x = point.y = point.z = std::numeric_limits<float>::quiet_NaN();
    }
  }
  cloud.is_dense = !holes;
  pcl::PCLPointCloud2 packed;
  pcl::toPCLPointCloud2(cloud, packed);
  return packed;
}

// Points of doubles between fields of other sizes.
pcl::PCLPointCloud2 of_doubles(uint32_t count) {
  using Kind = pcl::PCLPointField;
  pcl::PCLPointCloud2 cloud;
  const struct {
    const char* name;
    uint32_t offset;
    uint8_t kind;
    uint32_t count;
  } fields[] = {{"ring", 0, Kind::UINT16, 1},
                {"z", 2, Kind::FLOAT64, 1},
                {"x", 10, Kind::FLOAT64, 1},
                {"bins", 18, Kind::UINT8, 5},
                {"y", 23, Kind::FLOAT64, 1}};
  for (const auto& each : fields) {
    Kind field;
    field.name = each.name, field.offset = each.offset, field.datatype = each.kind, field.count = each.count;
    cloud.fields.push_back(field);
  }
  cloud.width = count, cloud.height = 1, cloud.point_step = 31, cloud.row_step = 31 * count;
  cloud.data.resize(cloud.row_step);
  for (uint32_t k = 0; k < count; ++k) {
    uint8_t* point = cloud.data.data() + 31 * k;
    const double places[3] = {0.1 * k, -1.0 / (k + 3.0), 1e-3 * k * k};
    for (int axis = 0; axis < 3; ++axis) std::memcpy(point + (const int[]){10, 23, 2}[axis], &places[axis], 8);
    point[0] = static_cast<uint8_t>(k);
  }
  return cloud;
}

void make(const std::string& folder) {
  const auto plain = sheet<pcl::PointXYZ>(7, 4, true, [](auto&) {});
  const auto coloured = sheet<pcl::PointXYZRGB>(5, 3, false, [](auto& point) { point.r = 200; });
  const auto doubles = of_doubles(9);
  const Eigen::Vector4f origin(0.5F, -0.25F, 1.0F, 0.0F);
  const Eigen::Quaternionf turned(0.0F, 1.0F, 0.0F, 0.0F);
  const Eigen::Vector4f none = Eigen::Vector4f::Zero();
  const Eigen::Quaternionf identity = Eigen::Quaternionf::Identity();
  pcl::PCDWriter pcd;
  const struct {
    const char* name;
    const pcl::PCLPointCloud2& cloud;
  } clouds[] = {{"plain", plain}, {"coloured", coloured}, {"doubles", doubles}};
  for (const auto& [name, cloud] : clouds) {
    const std::string path = folder + "/pcl_" + name;
    pcd.writeASCII(path + "_ascii.pcd", cloud, none, identity, 9);
    pcd.writeBinary(path + "_binary.pcd", cloud);
    pcd.writeBinaryCompressed(path + "_packed.pcd", cloud);
  }
  pcd.writeBinary(folder + "/pcl_moved.pcd", plain, origin, turned);
  pcl::PLYWriter ply;
  ply.writeASCII(folder + "/pcl_ascii.ply", plain, none, identity, 9, true);
  ply.writeASCII(folder + "/pcl_grid_ascii.ply", plain, none, identity, 9, false);
  ply.writeBinary(folder + "/pcl_binary.ply", coloured, none, identity, true);
  ply.writeBinary(folder + "/pcl_grid_binary.ply", plain, none, identity, false);
}

int list_file(const std::string& path) {
  pcl::PCLPointCloud2 cloud;
  const bool is_ply = path.substr(path.size() - 4) == ".ply";
  if ((is_ply ? pcl::PLYReader().read(path, cloud) : pcl::PCDReader().read(path, cloud)) < 0) return 1;
  for (uint32_t k = 0; k < cloud.width * cloud.height; ++k) {
    for (const char* axis : {"x", "y", "z"}) {
      for (const auto& field : cloud.fields) {
        if (field.name != axis) continue;
        const uint8_t* place = cloud.data.data() + k * cloud.point_step + field.offset;
        float single = 0;
        double value = 0;
        std::memcpy(&single, place, sizeof single);
        if (field.datatype == pcl::PCLPointField::FLOAT64)
          std::memcpy(&value, place, sizeof value);
        else
          value = static_cast<double>(single);
        std::printf(*axis == 'z' ? "%a\n" : "%a ", value);
      }
    }
  }
  return 0;
}

}  // namespace

int main(int count, char** words) {
  if (count != 3) return 2;
  if (std::string(words[1]) == "list") return list_file(words[2]);
  make(words[2]);
  return 0;
}
