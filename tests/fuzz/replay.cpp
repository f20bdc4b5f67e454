// Runs a fuzz target over the files of a corpus, for compilers without libFuzzer. Each input must return;
// crashes and sanitizers end the program, with the name of the input as the last line.
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

void replay(const std::string& name, const std::vector<char>& bytes) {
  std::printf("%s (%zu bytes)\n", name.c_str(), bytes.size());
  std::fflush(stdout);
  LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
}

}  // namespace

int main(int count, char** folders) {
  std::size_t inputs = 0;
  replay("no bytes", {});
  for (int i = 1; i < count; ++i) {
    std::error_code error;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folders[i], error)) {
      if (!entry.is_regular_file()) continue;
      std::ifstream file(entry.path(), std::ios::binary);
      std::vector<char> bytes{std::istreambuf_iterator<char>(file), {}};
      replay(entry.path().string(), bytes);
      // Cut short anywhere, a file is another input.
      for (std::size_t cut = 1; cut < 8; ++cut) {
        replay(entry.path().string() + " cut",
               {bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(bytes.size() * cut / 8)});
      }
      ++inputs;
    }
    if (error) std::printf("%s: %s\n", folders[i], error.message().c_str());
  }
  std::printf("%zu inputs\n", inputs);
  return inputs > 0 ? 0 : 1;  // an empty corpus tests nothing
}
