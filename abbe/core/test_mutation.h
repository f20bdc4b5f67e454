#pragma once

#include <random>
#include <string>

namespace abbe::test {

/// `text` with up to four small damages: a byte replaced, a few removed, a piece of it inserted. Test support
/// for readers that must be total.
inline std::string damaged(std::string text, std::mt19937& random, int damages) {
  for (int k = 0; k < damages && !text.empty(); ++k) {
    const std::size_t at = random() % text.size();
    switch (random() % 3) {
      case 0:
        text[at] = static_cast<char>(random());
        break;
      case 1:
        text.erase(at, random() % 12);
        break;
      default:
        text.insert(at, text.substr(random() % text.size(), random() % 20));
        break;
    }
  }
  return text;
}

}  // namespace abbe::test
