#pragma once

#include <nats/nats.h>

#include "common/handle/handle.h"

namespace haptics::nats {

using Options = Handle<natsOptions, &natsOptions_Destroy>;
using Connection = Handle<natsConnection, &natsConnection_Destroy>;
using Subscription = Handle<natsSubscription, &natsSubscription_Destroy>;
using Message = Handle<natsMsg, &natsMsg_Destroy>;
using Statistics = Handle<natsStatistics, &natsStatistics_Destroy>;
using JetStream = Handle<jsCtx, &jsCtx_Destroy>;

}  // namespace haptics::nats
