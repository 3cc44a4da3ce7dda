// Prints, for each file that is given, the sections of the prepared cell, or why it is none. Needs cell_file.cpp alone.
#include <fstream>
#include <iostream>
#include <iterator>

#include "library/cell_file.hpp"

int main(int count, char** arguments) {
  for (int i = 1; i < count; ++i) {
    std::ifstream stream(arguments[i], std::ios::binary);
    const std::vector<char> read{std::istreambuf_iterator<char>(stream), {}};
    try {
      const plannercheck::CellFile file(std::as_bytes(std::span(read)));
      for (const std::string& name : file.names()) std::cout << name << ';';
      std::cout << '\n';
    } catch (const plannercheck::CellError& error) {
      std::cout << "error: " << error.what() << '\n';
    }
  }
  return 0;
}
