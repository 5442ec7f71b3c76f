#include <google/protobuf/stubs/logging.h>

// Protobuf would write a line for each string that is not text, and be slower than what is tested.
extern "C" int LLVMFuzzerInitialize(int* /*argc*/, char*** /*argv*/) {
  google::protobuf::SetLogHandler(nullptr);
  return 0;
}
