#include <cstdlib>
#include <iostream>
#include <string>
#include <vector>

#include "tools/cli/command_line.h"

int main(int argc, char** argv) {
  egosieve::tools::CommandLine line(
      "egosieve",
      "Finds, in video from one uncalibrated moving camera, the pixels of what moves by itself.",
      "0.1.0");
  return line.Run(std::vector<std::string>(argv + 1, argv + argc), std::cout, std::cerr);
}
