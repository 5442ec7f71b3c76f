#pragma once

#include <hdf5.h>

#include <array>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

// What HDF5's C interface takes, closed when it is let go of. A call that fails throws Hdf5Failure.
namespace haptics {

class Hdf5Failure : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// What the library calls an id, of which `Close` gets rid.
template <herr_t (*Close)(hid_t)>
class Hdf5Handle {
 public:
  /// Throws where the library gave none; `what` says what was tried.
  Hdf5Handle(hid_t id, const std::string& what) : id_(id) {
    if (id < 0) throw Hdf5Failure(what);
  }
  ~Hdf5Handle() {
    if (id_ >= 0) Close(id_);
  }
  Hdf5Handle(Hdf5Handle&& other) noexcept : id_(std::exchange(other.id_, H5I_INVALID_HID)) {}
  Hdf5Handle& operator=(Hdf5Handle&& other) noexcept {
    std::swap(id_, other.id_);
    return *this;
  }
  operator hid_t() const noexcept { return id_; }

 private:
  hid_t id_;
};
using Hdf5Space = Hdf5Handle<H5Sclose>;
using Hdf5Set = Hdf5Handle<H5Dclose>;
using Hdf5Group = Hdf5Handle<H5Gclose>;
using Hdf5List = Hdf5Handle<H5Pclose>;

template <class T>
[[nodiscard]] hid_t hdf5Type() noexcept {
  if constexpr (std::is_same_v<T, double>) return H5T_NATIVE_DOUBLE;
  if constexpr (std::is_same_v<T, float>) return H5T_NATIVE_FLOAT;
  if constexpr (std::is_same_v<T, std::uint64_t>) return H5T_NATIVE_UINT64;
  if constexpr (std::is_same_v<T, std::uint32_t>) return H5T_NATIVE_UINT32;
}

/// Attributes of a group, a data set, or of the file itself.
void setAttribute(hid_t of, const char* name, const std::string& text);
void setAttribute(hid_t of, const char* name, double value);
void setAttribute(hid_t of, const char* name, std::uint64_t value);

[[nodiscard]] Hdf5Group makeGroup(hid_t in, const std::string& name);
/// A data set of rows x width that is written at once; width 1: of one dimension.
template <class T>
Hdf5Set writeRows(hid_t in, const std::string& name, std::span<const T> values, std::size_t width) {
  const std::array<hsize_t, 2> size{values.size() / width, width};
  const Hdf5Space space(H5Screate_simple(width == 1 ? 1 : 2, size.data(), nullptr), name);
  Hdf5Set set(H5Dcreate2(in, name.c_str(), hdf5Type<T>(), space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), name);
  if (!values.empty() && H5Dwrite(set, hdf5Type<T>(), H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) < 0)
    throw Hdf5Failure(name);
  return set;
}

inline constexpr int kDeflateLevel = 1;  ///< Higher ones take several times as long for some percent.

/// Writes a whole chunk of a data set that is shuffled and deflated, as the library's filters would, in less time.
/// @param begin  Its first element in the data set, as many numbers as that has dimensions.
void writeChunk(hid_t set, const std::string& name, const hsize_t* begin, std::span<const std::uint64_t> words);

/// A data set that grows row by row: chunked, shuffled, deflated.
template <class T>
class Hdf5Rows {
  static_assert(sizeof(T) == sizeof(std::uint64_t));

 public:
  /// @param perChunk  Rows that are written together.
  Hdf5Rows(hid_t in, const std::string& name, std::size_t width, std::size_t perChunk)
      : name_(name), width_(width), perChunk_(perChunk), set_(make(in)) {
    buffer_.reserve(perChunk * width);
  }

  [[nodiscard]] hid_t set() const noexcept { return set_; }
  /// @return Where the next row's values go.
  [[nodiscard]] T* next() {
    if (buffer_.size() == perChunk_ * width_) flush();
    buffer_.resize(buffer_.size() + width_);
    return buffer_.data() + buffer_.size() - width_;
  }
  void flush() {
    if (buffer_.empty()) return;
    const std::array<hsize_t, 2> count{buffer_.size() / width_, width_}, begin{rows_, 0};
    const std::array<hsize_t, 2> size{rows_ + count[0], width_};
    if (H5Dset_extent(set_, size.data()) < 0) throw Hdf5Failure(name_);
    if (count[0] == perChunk_) {
      writeChunk(set_, name_, begin.data(), {reinterpret_cast<const std::uint64_t*>(buffer_.data()), buffer_.size()});
    } else {
      writeRest(count, begin);
    }
    rows_ = size[0];
    buffer_.clear();
  }

 private:
  std::string name_;
  std::size_t width_, perChunk_;
  Hdf5Set set_;
  hsize_t rows_ = 0;
  std::vector<T> buffer_;

  void writeRest(const std::array<hsize_t, 2>& count, const std::array<hsize_t, 2>& begin) const {
    const int dimensions = width_ == 1 ? 1 : 2;
    const Hdf5Space file(H5Dget_space(set_), name_), memory(H5Screate_simple(dimensions, count.data(), nullptr), name_);
    if (H5Sselect_hyperslab(file, H5S_SELECT_SET, begin.data(), nullptr, count.data(), nullptr) < 0 ||
        H5Dwrite(set_, hdf5Type<T>(), memory, file, H5P_DEFAULT, buffer_.data()) < 0)
      throw Hdf5Failure(name_);
  }

  [[nodiscard]] Hdf5Set make(hid_t in) const {
    const int dimensions = width_ == 1 ? 1 : 2;
    const std::array<hsize_t, 2> none{0, width_}, most{H5S_UNLIMITED, width_}, chunk{perChunk_, width_};
    const Hdf5Space space(H5Screate_simple(dimensions, none.data(), most.data()), name_);
    const Hdf5List list(H5Pcreate(H5P_DATASET_CREATE), name_);
    if (H5Pset_chunk(list, dimensions, chunk.data()) < 0 || H5Pset_shuffle(list) < 0 ||
        H5Pset_deflate(list, kDeflateLevel) < 0)
      throw Hdf5Failure(name_);
    return {H5Dcreate2(in, name_.c_str(), hdf5Type<T>(), space, H5P_DEFAULT, list, H5P_DEFAULT), name_};
  }
};

}  // namespace haptics
