// SPDX-License-Identifier: Apache-2.0
// Whatever a camera sends: a value or a named rule, never a crash, and never a frame that is larger than it is. The
// first byte chooses what it is taken for.
#include <cstdint>
#include <cstdlib>
#include <string>

#include "core/base/error.h"
#include "drivers/u3v_depth.h"
#include "drivers/u3v_protocol.h"
#include "drivers/zip_file.h"

namespace {

using namespace geond::drivers;

void Check(bool holds) {
  if (!holds) std::abort();
}

void TakeAck(u3v::ByteView packet, u3v::Command command) {
  const u3v::Ack ack = u3v::DecodeAck(packet, command, 7, 16);
  using Kind = u3v::Ack::Kind;
  Check(ack.kind != Kind::kBroken || !ack.error.empty());
  Check(ack.kind != Kind::kAnswer || command != u3v::Command::kReadMem || ack.data.size() == 16);
  u3v::StatusWords(ack.status);
}

// A frame: leader, trailer and payload one after the other.
void TakeFrame(u3v::ByteView bytes) {
  constexpr std::size_t kLeader = 52, kTrailer = 32;
  if (bytes.size() < kLeader + kTrailer) return;
  std::string error;
  const auto leader = u3v::DecodeLeader(bytes.first(kLeader), error);
  Check(leader || !error.empty());
  const auto trailer = u3v::DecodeTrailer(bytes.subspan(kLeader, kTrailer), error);
  Check(trailer || !error.empty());
  if (!leader || !trailer) return;
  const auto again = u3v::DecodeLeader(u3v::EncodeLeader(*leader), error);
  Check(again && again->width == leader->width && again->block_id == leader->block_id);
  const u3v::ByteView payload = bytes.subspan(kLeader + kTrailer);
  if (!u3v::FrameFault(*leader, *trailer, payload.size()).empty()) return;
  const geond::RangeImage image = u3v::DecodeDepth({*leader, *trailer, u3v::Bytes(payload.begin(), payload.end())}, {});
  Check(image.depth.size() == std::size_t{leader->width} * trailer->height);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const u3v::ByteView rest(data + 1, size - 1);
  switch (data[0] % 4) {
    case 0:
      TakeAck(rest, u3v::Command::kReadMem);
      break;
    case 1:
      TakeAck(rest, u3v::Command::kWriteMem);
      break;
    case 2:
      TakeFrame(rest);
      break;
    default:
      try {
        UnzipFirstFile(rest);
      } catch (const geond::DeviceError&) {
      }
  }
  return 0;
}
