#include "graphics_client/export/hdf5_file.h"

namespace haptics {
namespace {

using Hdf5Attribute = Hdf5Handle<H5Aclose>;
using Hdf5Type = Hdf5Handle<H5Tclose>;

void writeAttribute(hid_t of, const char* name, hid_t type, const void* value) {
  const Hdf5Space space(H5Screate(H5S_SCALAR), name);
  const Hdf5Attribute attribute(H5Acreate2(of, name, type, space, H5P_DEFAULT, H5P_DEFAULT), name);
  if (H5Awrite(attribute, type, value) < 0) throw Hdf5Failure(name);
}

}  // namespace

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
