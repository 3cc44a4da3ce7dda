// Maps that the OctoMap library writes, and the cells that it lists of any map.
//
// In: `make FOLDER`, or `list FILE`. Out: .bt and .ot files, or on standard output the leaves that OctoMap's iterator
// gives, which of them it calls occupied at several thresholds, and what its search says of every cell of the box
// around them. README.md has the commands.

#include <octomap/ColorOcTree.h>
#include <octomap/OcTree.h>
#include <octomap/OcTreeStamped.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <memory>
#include <string>

namespace {

constexpr int kLowest = -32768;
constexpr long kLargestBox = 6000;

octomap::OcTreeKey key_of(int x, int y, int z) {
  return {static_cast<octomap::key_type>(x - kLowest), static_cast<octomap::key_type>(y - kLowest),
          static_cast<octomap::key_type>(z - kLowest)};
}

template <class Tree>
void set_block(Tree& tree, int x, int y, int z, int edge, float log_odds) {
  for (int i = 0; i < edge; ++i)
    for (int j = 0; j < edge; ++j)
      for (int k = 0; k < edge; ++k) tree.setNodeValue(key_of(x + i, y + j, z + k), log_odds, true);
}

// Rays from a sensor to points of a wall and a box: free cells along them, occupied ones at their ends.
template <class Tree>
void look_around(Tree& tree) {
  octomap::Pointcloud cloud;
  for (int i = -4; i <= 4; ++i) {
    cloud.push_back(0.9F, 0.08F * static_cast<float>(i), 0.03F * static_cast<float>(i * i));
    cloud.push_back(0.5F, 0.05F * static_cast<float>(i), -0.4F);
  }
  const octomap::point3d sensor(0.01F, 0.02F, 0.03F);
  tree.insertPointCloud(cloud, sensor);
  tree.insertRay(sensor, octomap::point3d(-0.7F, 0.3F, 0.1F));
  tree.insertRay(sensor, octomap::point3d(-0.7F, 0.3F, 0.1F));
}

template <class Tree>
void write_blocks(Tree& tree) {
  set_block(tree, 0, 0, 0, 8, 1.5F);      // one cell of 8 steps when pruned
  set_block(tree, -8, 0, 0, 4, -0.75F);   // one free cell of 4
  set_block(tree, -4, 4, 4, 2, 0.125F);   // one of 2
  set_block(tree, -2, -2, -2, 1, -2.5F);  // one of 1
  set_block(tree, 8, 0, 0, 3, 0.0F);      // log-odds of 0: a probability of exactly one half
  set_block(tree, 3, 3, -1, 1, -0.0F);
  set_block(tree, 4, 3, -1, 1, 0.8472979F);  // a probability of 0.7, about
  set_block(tree, 5, 3, -1, 1, -0.8472979F);
  tree.updateInnerOccupancy();
}

void write_file(const std::string& path, const std::string& content) {
  std::ofstream(path, std::ios::binary) << content;
}

void make(const std::string& folder) {
  octomap::OcTree room(0.1);
  look_around(room);
  room.write(folder + "/room.ot");
  room.writeBinary(folder + "/room.bt");  // prunes, and clamps all log-odds

  octomap::OcTree blocks(0.05);
  write_blocks(blocks);
  octomap::OcTree few(0.3);
  set_block(few, -4, 0, 8, 4, 3.5F);
  set_block(few, 1, 1, 1, 1, -2.0F);
  few.updateInnerOccupancy();
  few.write(folder + "/not_pruned.ot");
  few.writeBinaryConst(folder + "/not_pruned.bt");
  blocks.prune();
  blocks.write(folder + "/blocks.ot");
  blocks.writeBinaryConst(folder + "/blocks.bt");

  octomap::ColorOcTree colours(0.02);
  write_blocks(colours);
  for (int i = 0; i < 8; ++i)
    colours.setNodeColor(key_of(i, i, i), static_cast<uint8_t>(30 * i), 255, static_cast<uint8_t>(i));
  colours.updateInnerOccupancy();
  colours.prune();
  colours.write(folder + "/colours.ot");
  colours.writeBinaryConst(folder + "/colours.bt");

  octomap::OcTreeStamped stamped(0.25);
  look_around(stamped);
  stamped.write(folder + "/stamped.ot");

  octomap::OcTree corners(1.0 / 3);
  const int last = -kLowest - 1;
  for (const int x : {kLowest, -1, 0, last})
    for (const int z : {kLowest, last}) corners.setNodeValue(key_of(x, -x - 1, z), x < 0 ? 3.5F : -2.0F, true);
  corners.updateInnerOccupancy();
  corners.write(folder + "/corners.ot");
  corners.writeBinaryConst(folder + "/corners.bt");

  octomap::OcTree empty(0.1);
  empty.write(folder + "/empty.ot");
  empty.writeBinaryConst(folder + "/empty.bt");

  // What no writer makes any more: a root without children, and OctoMap's first header.
  write_file(folder + "/root.bt",
             std::string("# Octomap OcTree binary file\nid OcTree\nsize 1\nres 0.1\ndata\n") + std::string(2, '\0'));
  char header[16];
  const int32_t kind = 3;
  const double resolution = 0.2;
  const uint32_t nodes = 4;
  std::memcpy(header, &kind, 4);
  std::memcpy(header + 4, &resolution, 8);
  std::memcpy(header + 12, &nodes, 4);
  const char data[2] = {static_cast<char>(0b10010010), 0};
  write_file(folder + "/first_format.bt", std::string(header, 16) + std::string(data, 2));
}

template <class Tree>
void list(Tree& tree) {
  std::printf("resolution %a\nleaves %zu\n", tree.getResolution(), tree.size() == 0 ? 0 : tree.getNumLeafNodes());
  int low[3] = {-kLowest, -kLowest, -kLowest}, high[3] = {kLowest, kLowest, kLowest};
  if (tree.size() > 0) {
    for (auto leaf = tree.begin_leafs(); leaf != tree.end_leafs(); ++leaf) {
      const int size = 1 << (16 - leaf.getDepth());
      const octomap::OcTreeKey key = leaf.getIndexKey();
      std::printf("%d %d %d %d %a\n", key[0] + kLowest, key[1] + kLowest, key[2] + kLowest, size,
                  static_cast<double>(leaf->getLogOdds()));
      for (unsigned axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], key[axis] + kLowest);
        high[axis] = std::max(high[axis], key[axis] + kLowest + size);
      }
    }
  }
  for (const double threshold : {0.1192, 0.3, 0.5, 0.7, 0.971}) {
    tree.setOccupancyThres(threshold);
    std::printf("threshold %g ", threshold);
    if (tree.size() > 0)
      for (auto leaf = tree.begin_leafs(); leaf != tree.end_leafs(); ++leaf)
        std::putchar(tree.isNodeOccupied(*leaf) ? '1' : '0');
    std::printf("\n");
  }
  tree.setOccupancyThres(0.5);
  const long sides[3] = {high[0] - low[0], high[1] - low[1], high[2] - low[2]};
  if (sides[0] <= 0 || sides[0] * sides[1] * sides[2] > kLargestBox) return;
  std::printf("box %d %d %d %ld %ld %ld\n", low[0], low[1], low[2], sides[0], sides[1], sides[2]);
  for (int x = low[0]; x < high[0]; ++x) {
    for (int y = low[1]; y < high[1]; ++y) {
      for (int z = low[2]; z < high[2]; ++z) {
        const auto* node = tree.search(key_of(x, y, z));
        std::putchar(node == nullptr ? '?' : tree.isNodeOccupied(*node) ? '#' : '.');
      }
      std::printf("\n");
    }
  }
}

template <class Tree>
bool list_binary(const std::string& path) {
  Tree tree(1.0);
  if (!tree.readBinary(path)) return false;
  list(tree);
  return true;
}

bool list_file(const std::string& path) {
  if (path.substr(path.size() - 3) == ".bt") {
    if (path.find("colours") != std::string::npos) return list_binary<octomap::ColorOcTree>(path);
    return list_binary<octomap::OcTree>(path);
  }
  const std::unique_ptr<octomap::AbstractOcTree> read(octomap::AbstractOcTree::read(path));
  if (auto* plain = dynamic_cast<octomap::OcTree*>(read.get()))
    list(*plain);
  else if (auto* coloured = dynamic_cast<octomap::ColorOcTree*>(read.get()))
    list(*coloured);
  else if (auto* stamped = dynamic_cast<octomap::OcTreeStamped*>(read.get()))
    list(*stamped);
  else
    return false;
  return true;
}

}  // namespace

int main(int count, char** words) {
  if (count != 3) return 2;
  if (std::string(words[1]) == "list") return list_file(words[2]) ? 0 : 1;
  make(words[2]);
  return 0;
}
