// SPDX-License-Identifier: Apache-2.0
// What the fake camera sends: frames, whole or faulty, as the host reads them.
#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "drivers/little_endian.h"
#include "drivers/u3v_protocol.h"
#include "sim/fake_camera.h"
#include "sim/fake_camera_registers.h"

namespace geond::sim {
namespace {

using namespace fake_camera;
namespace u3v = drivers::u3v;
using drivers::AppendLittleEndian;

constexpr std::size_t kPacket = 1024;

bool HasSides(std::uint64_t format) {
  return format == static_cast<std::uint64_t>(u3v::PixelFormat::kCoord3dAbc16) ||
         format == static_cast<std::uint64_t>(u3v::PixelFormat::kCoord3dAbc32f);
}

}  // namespace

bool FakeCamera::RunsFree() const {
  return acquiring_ && Get(kFeatures + kTriggerMode, 4) == 0 && (Get(kStream + 0x04, 4) & 1) != 0;
}

FakeCamera::Bytes FakeCamera::EncodePayload(const RangeImage& image, std::uint32_t rows) const {
  const auto columns = static_cast<std::uint32_t>(Get(kFeatures + kWidth, 4));
  const std::uint64_t format = Get(kFeatures + kPixelFormat, 4);
  Bytes payload;
  payload.reserve(std::size_t{rows} * columns * u3v::BytesPerPixel(static_cast<std::uint32_t>(format)) + kChunkBytes);
  const auto append = [&](double metres) {
    if (IsWholeNumber(format)) {
      const double steps = std::round(metres * kUnitsPerMetre16);
      AppendLittleEndian(static_cast<std::uint16_t>(steps > 65535.0 || steps < 0.0 ? 0.0 : steps), payload);
    } else {
      AppendLittleEndian(std::bit_cast<std::uint32_t>(static_cast<float>(metres)), payload);
    }
  };
  for (std::uint32_t row = 0; row < rows; ++row) {
    for (std::uint32_t column = 0; column < columns; ++column) {
      const bool inside = image.contains(static_cast<int>(column), static_cast<int>(row));
      const float depth = inside ? image.at(static_cast<int>(column), static_cast<int>(row)) : 0.0f;
      const double sent = depth > 0.0f ? static_cast<double>(depth) : 0.0;
      if (HasSides(format)) {
        const Eigen::Vector3d p_S = Unproject(sensor_, column, row, sent);
        append(p_S.x());
        append(p_S.y());
      }
      append(sent);
    }
  }
  if (chunks_) {
    const auto image_size = static_cast<std::uint32_t>(payload.size());
    for (const std::uint32_t word : {1u, image_size, 0x1234u, 0u, 2u, 8u}) AppendLittleEndian(word, payload);
  }
  return payload;
}

void FakeCamera::SendFrame() {
  const bool again = RunsFree() && !free_payload_.empty();
  const std::optional<RangeImage> taken = again ? std::nullopt : take_();
  if (!taken && !again) return;
  u3v::Leader leader;
  leader.block_id = block_++;
  leader.payload_type = chunks_ ? u3v::kImageWithChunksPayload : u3v::kImagePayload;
  leader.timestamp_ns = (frames_ + 1) * 1'000'000;
  leader.pixel_format = static_cast<std::uint32_t>(Get(kFeatures + kPixelFormat, 4));
  leader.width = static_cast<std::uint32_t>(Get(kFeatures + kWidth, 4));
  leader.height = static_cast<std::uint32_t>(Get(kFeatures + kHeight, 4));
  u3v::Trailer trailer;
  trailer.block_id = leader.block_id;
  trailer.height = leader.height;
  if (TakeOne(faults_.lost_frames) || (faults_.every_second_lost && leader.block_id % 2 == 0)) return;
  if (TakeOne(faults_.half_images)) trailer.height /= 2;
  Bytes payload = again ? free_payload_ : EncodePayload(*taken, trailer.height);
  if (RunsFree() && !again) free_payload_ = payload;
  // Not a whole number of packets, so that the host sees its end.
  if (TakeOne(faults_.short_payloads)) payload.resize(payload.size() / 2 / kPacket * kPacket + 100);
  trailer.valid_payload_size = payload.size();
  if (TakeOne(faults_.overrun_trailers)) trailer.status = 0xA101;
  if (TakeOne(faults_.wrong_blocks)) ++trailer.block_id;
  Bytes head = u3v::EncodeLeader(leader);
  if (TakeOne(faults_.bad_leaders)) head[0] = 0;
  if (TakeOne(faults_.stream_stalls)) {
    stream_halted_ = true;
    stream_.clear();
    return;
  }
  const Clock::time_point ready = Clock::now() + exposure_time_ + faults_.frame_delay;
  stream_.push_back({std::move(head), ready});
  stream_.push_back({std::move(payload), ready, trailer.height < leader.height});
  Bytes tail = u3v::EncodeTrailer(trailer);
  if (chunks_) {
    AppendLittleEndian(std::uint32_t{1}, tail);  // the layout's number
    tail[6] = static_cast<std::uint8_t>(tail.size());
  }
  stream_.push_back({std::move(tail), ready});
  ++frames_;
}

int FakeCamera::ReadStream(std::span<std::uint8_t> data) {
  if (stream_.empty() && RunsFree()) SendFrame();
  std::size_t done = 0;
  while (done < data.size() && !stream_.empty() && stream_.front().ready <= Clock::now()) {
    const Bytes& message = stream_.front().bytes;
    const std::size_t left = message.size() - stream_at_, room = data.size() - done;
    if (room < left && room % kPacket != 0) return kOverflow;
    const std::size_t count = std::min(left, room);
    std::copy_n(message.begin() + static_cast<std::ptrdiff_t>(stream_at_), count,
                data.begin() + static_cast<std::ptrdiff_t>(done));
    done += count;
    stream_at_ += count;
    if (stream_at_ < message.size()) break;
    const bool short_packet = message.size() % kPacket != 0 || stream_.front().ends_early;
    stream_.pop_front();
    stream_at_ = 0;
    if (short_packet) break;
  }
  return done == 0 ? kNothingYet : static_cast<int>(done);
}

}  // namespace geond::sim
