# Writes OUT, with the SHA-256 of all files of SOURCES (paths relative to TOP, as a list), in order of their names:
# two builds with the same hash make the same forces of the same recording.
list(SORT SOURCES)
set(all "")
foreach(source IN LISTS SOURCES)
  file(SHA256 ${TOP}/${source} hash)
  string(APPEND all "${source} ${hash}\n")
endforeach()
string(SHA256 whole "${all}")
string(REGEX REPLACE "(..)" "0x\\1, " bytes ${whole})
set(text "#include <string_view>

namespace haptics {

std::string_view ownStepSources() noexcept;

std::string_view ownStepSources() noexcept {
  static constexpr unsigned char kHash[]{${bytes}};
  return {reinterpret_cast<const char*>(kHash), sizeof kHash};
}

}  // namespace haptics
")
if(EXISTS ${OUT})
  file(READ ${OUT} before)
endif()
if(NOT "${before}" STREQUAL "${text}")
  file(WRITE ${OUT} "${text}")
endif()
