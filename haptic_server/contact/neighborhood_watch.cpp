#include "haptic_server/contact/neighborhood_watch_impl.h"

namespace haptics {

template SearchResult neighborhoodWatch<AllCorrections>(const Surface&, const Foot&, Vec3, SearchPath*, int&) noexcept;

}  // namespace haptics
