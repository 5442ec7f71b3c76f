#include "graphics_client/export/hdf5_file.h"

#include <libdeflate.h>

#include <memory>
#include <new>

namespace haptics {
namespace {

using Hdf5Attribute = Hdf5Handle<H5Aclose>;
using Hdf5Type = Hdf5Handle<H5Tclose>;

void writeAttribute(hid_t of, const char* name, hid_t type, const void* value) {
  const Hdf5Space space(H5Screate(H5S_SCALAR), name);
  const Hdf5Attribute attribute(H5Acreate2(of, name, type, space, H5P_DEFAULT, H5P_DEFAULT), name);
  if (H5Awrite(attribute, type, value) < 0) throw Hdf5Failure(name);
}

/// The first bytes of all words, then the second ones, and so on: the library's filter "shuffle".
void shuffle(std::span<const std::uint64_t> words, std::vector<unsigned char>& bytes) {
  bytes.resize(words.size_bytes());
  for (std::size_t i = 0; i < words.size(); ++i) {
    for (std::size_t b = 0; b < sizeof(std::uint64_t); ++b)
      bytes[b * words.size() + i] = static_cast<unsigned char>(words[i] >> (8 * b));
  }
}

/// Packs with the memory of the last time.
class Packer {
 public:
  Packer() : compressor_(libdeflate_alloc_compressor(kDeflateLevel)) {
    if (!compressor_) throw std::bad_alloc();
  }

  [[nodiscard]] std::span<const unsigned char> pack(std::span<const std::uint64_t> words) {
    shuffle(words, shuffled_);
    packed_.resize(libdeflate_zlib_compress_bound(compressor_.get(), shuffled_.size()));
    return {packed_.data(), libdeflate_zlib_compress(compressor_.get(), shuffled_.data(), shuffled_.size(),
                                                     packed_.data(), packed_.size())};
  }

 private:
  struct Free {
    void operator()(libdeflate_compressor* compressor) const noexcept { libdeflate_free_compressor(compressor); }
  };
  std::unique_ptr<libdeflate_compressor, Free> compressor_;
  std::vector<unsigned char> shuffled_, packed_;
};

}  // namespace

void writeChunk(hid_t set, const std::string& name, const hsize_t* begin, std::span<const std::uint64_t> words) {
  constexpr std::uint32_t kAllFilters = 0;
  thread_local Packer packer;
  const auto packed = packer.pack(words);
  if (H5Dwrite_chunk(set, H5P_DEFAULT, kAllFilters, begin, packed.size(), packed.data()) < 0) throw Hdf5Failure(name);
}

void setAttribute(hid_t of, const char* name, const std::string& text) {
  const Hdf5Type type(H5Tcopy(H5T_C_S1), name);
  if (H5Tset_size(type, H5T_VARIABLE) < 0 || H5Tset_cset(type, H5T_CSET_UTF8) < 0) throw Hdf5Failure(name);
  const char* const begin = text.c_str();
  writeAttribute(of, name, type, &begin);
}

void setAttribute(hid_t of, const char* name, double value) { writeAttribute(of, name, H5T_NATIVE_DOUBLE, &value); }

void setAttribute(hid_t of, const char* name, std::uint64_t value) {
  writeAttribute(of, name, H5T_NATIVE_UINT64, &value);
}

Hdf5Group makeGroup(hid_t in, const std::string& name) {
  return {H5Gcreate2(in, name.c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), name};
}

}  // namespace haptics
