#pragma once

#include <string_view>

#include "abbe/verify/klartext_items.h"

namespace abbe::verifying {

/// Blocks that define cycles: CYCL DEF and its lines, the Q words of drilling cycles, the preset of cycle
/// 247. Only for the scanner of read_klartext_words.
class KlartextCycles : public KlartextItems {
 public:
  using KlartextItems::KlartextItems;

 protected:
  bool definition();
  bool lacks_preset(std::string_view at);
  bool hole_words(int cycle, std::string_view rest);
  bool preset(std::size_t i);

 private:
  bool datum_frame(const Profile::Keyword& word, Meaning meaning);
  bool hole_line(int cycle, int number_of_line);
};

}  // namespace abbe::verifying
