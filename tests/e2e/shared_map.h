// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace waystone {

class ChildProcess;

// What a run of the program left behind.
struct RunResult {
  int code = 0;
  std::string out;
  std::string err;
};

// Runs the real program with these arguments (each is quoted for the shell) and waits.
// `limits` is put in front of it in the shell ("ulimit -f 8;").
RunResult RunWaystone(const std::vector<std::string>& arguments, const std::string& limits = "");

// Waits until a program that was started takes a signal itself, which on a busy machine can be long
// after; a minute at most.
void AwaitHandlerOf(const ChildProcess& program, int signal);

// A small walk through a made room, its map, and photos: made once, for all tests of this program.
// Read-only for the tests.
struct SharedMap {
  std::filesystem::path folder;     // for everything; goes away at the end
  std::filesystem::path images;     // the walk's pictures
  std::filesystem::path map;        // "room.db", built from them by the program, on two threads
  std::filesystem::path inside;     // a photo from between two of the walk's frames
  std::filesystem::path elsewhere;  // a photo of another building
  RunResult build;                  // of that map
};
const SharedMap& TheMap();

// Pictures `first` to `last` of that walk, through the room with pictures on its northern wall:
// letters in a line of 16 walls ("###a###b########").
void RenderPosters(const std::string& wall, const std::filesystem::path& folder, int first,
                   int last);

std::string ReadFile(const std::filesystem::path& path);
void WriteFile(const std::filesystem::path& path, const std::string& bytes);

// A JPEG whose header claims another size.
std::string WithJpegSize(std::string jpeg, int width, int height);

// A new empty folder of the running test's own.
std::filesystem::path FreshFolder();

}  // namespace waystone
