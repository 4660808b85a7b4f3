// SPDX-License-Identifier: Apache-2.0
// replay FOLDER [ROUNDS]: gives a fuzz target each file of its corpus, and each ROUNDS times changed at random places,
// by a fixed seed. For compilers without libFuzzer, and for a short look at every target wherever tests run.
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

using Bytes = std::vector<std::uint8_t>;

void Change(Bytes& bytes, const Bytes& other, std::mt19937_64& random) {
  for (std::uint64_t n = 1 + random() % 4; n > 0; --n) {
    const std::size_t at = random() % (bytes.size() + 1);
    const auto place = bytes.begin() + static_cast<std::ptrdiff_t>(at);
    const auto count = static_cast<std::ptrdiff_t>(std::min<std::size_t>(1 + random() % 16, bytes.size() - at));
    switch (random() % 4) {
      case 0:
        if (at < bytes.size()) bytes[at] = static_cast<std::uint8_t>(random());
        break;
      case 1:
        bytes.erase(place, place + count);
        break;
      case 2:
        bytes.insert(place, 1 + random() % 16, static_cast<std::uint8_t>(random()));
        break;
      default:  // its end becomes another's
        bytes.resize(at);
        bytes.insert(bytes.end(), other.begin() + static_cast<std::ptrdiff_t>(random() % (other.size() + 1)),
                     other.end());
    }
  }
}

}  // namespace

int main(int count, char** arguments) {
  if (count < 2) return 2;
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(arguments[1])) files.push_back(entry.path());
  std::ranges::sort(files);
  std::vector<Bytes> corpus;
  for (const auto& file : files) {
    std::ifstream in(file, std::ios::binary);
    corpus.emplace_back(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
  }
  if (corpus.empty()) {
    std::fprintf(stderr, "%s is empty\n", arguments[1]);
    return 1;
  }
  const int rounds = count > 2 ? std::atoi(arguments[2]) : 100;
  std::mt19937_64 random(1);
  for (const Bytes& bytes : corpus) LLVMFuzzerTestOneInput(bytes.data(), bytes.size());
  for (int round = 0; round < rounds; ++round) {
    for (const Bytes& bytes : corpus) {
      Bytes changed = bytes;
      Change(changed, corpus[random() % corpus.size()], random);
      LLVMFuzzerTestOneInput(changed.data(), changed.size());
    }
  }
  std::printf("%zu files, each changed %d times\n", corpus.size(), rounds);
}
