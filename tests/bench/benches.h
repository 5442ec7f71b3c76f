#pragma once

namespace haptics::bench {

/// The contact tick hot and cold, the search alone, and the whole step.
void registerContact();
/// The database's build, and its size.
void registerBuild();

}  // namespace haptics::bench
