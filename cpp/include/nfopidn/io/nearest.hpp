// L4. The word that was probably meant, for messages that refuse another one.
#pragma once

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "nfopidn/foundation/host.hpp"

namespace nfopidn {

// How many insertions, deletions, changes of a letter and exchanges of two neighbouring letters
// turn one word into the other, where no letter is touched twice (optimal string alignment).
NFOPIDN_HOST std::size_t edit_distance(std::string_view one, std::string_view other);

// The known word with the fewest edits, at most one for every three letters of the longer word;
// empty where none is that near. Case and the difference of '_' and '-' do not count. Words of
// more than 64 letters are no slips.
NFOPIDN_HOST std::string nearest_word(const std::string& word,
                                      const std::vector<std::string>& known);

// " (did you mean mass?)", to stand behind the refused word; empty where no word is near.
NFOPIDN_HOST std::string suggestion(const std::string& word, const std::vector<std::string>& known);

}  // namespace nfopidn

#ifdef NFOPIDN_DEFINES_IO

namespace nfopidn {

NFOPIDN_HOST std::size_t edit_distance(std::string_view one, std::string_view other) {
  std::vector<std::size_t> previous, row(other.size() + 1), next(other.size() + 1);
  for (std::size_t j = 0; j <= other.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= one.size(); ++i) {
    next[0] = i;
    for (std::size_t j = 1; j <= other.size(); ++j) {
      const std::size_t change = one[i - 1] == other[j - 1] ? 0 : 1;
      next[j] = std::min({row[j] + 1, next[j - 1] + 1, row[j - 1] + change});
      const bool exchanged =
          i > 1 && j > 1 && one[i - 1] == other[j - 2] && one[i - 2] == other[j - 1];
      if (exchanged) next[j] = std::min(next[j], previous[j - 2] + 1);
    }
    previous = row;
    std::swap(row, next);
  }
  return row[other.size()];
}

NFOPIDN_HOST std::string nearest_word(const std::string& word,
                                      const std::vector<std::string>& known) {
  constexpr std::size_t longest = 64;
  constexpr std::size_t letters_per_edit = 3;
  if (word.size() > longest) return "";
  const auto folded = [](std::string text) {
    for (char& c : text) {
      if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
      if (c == '_') c = '-';
    }
    return text;
  };
  std::string nearest;
  std::size_t fewest = longest;
  for (const std::string& candidate : known) {
    const std::size_t distance = edit_distance(folded(word), folded(candidate));
    const std::size_t most = std::max(word.size(), candidate.size()) / letters_per_edit;
    if (distance > most || distance >= fewest) continue;
    nearest = candidate;
    fewest = distance;
  }
  return nearest;
}

NFOPIDN_HOST std::string suggestion(const std::string& word,
                                    const std::vector<std::string>& known) {
  const std::string nearest = nearest_word(word, known);
  return nearest.empty() ? "" : " (did you mean " + nearest + "?)";
}

}  // namespace nfopidn

#endif  // NFOPIDN_DEFINES_IO
