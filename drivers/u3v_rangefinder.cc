// SPDX-License-Identifier: Apache-2.0
#include "drivers/u3v_rangefinder.h"

#include <cmath>
#include <condition_variable>
#include <stdexcept>

#include "core/base/error.h"
#include "drivers/little_endian.h"
#include "drivers/usb_guard.h"
#include "drivers/zip_file.h"

namespace geond::drivers {
namespace {

constexpr char kName[] = "camera";
constexpr std::uint64_t kManifestAddress = 0x01d0;
constexpr std::size_t kManifestEntry = 64;
constexpr std::uint64_t kLargestDescription = 16 << 20;
// Registers of the stream, from their base.
constexpr std::uint64_t kInfo = 0x00, kStreamControl = 0x04, kPayload = 0x08, kLeader = 0x10, kTrailer = 0x14;
constexpr std::uint64_t kMaxLeader = 0x18, kTransferSize = 0x1c, kTransferCount = 0x20, kTransfer1 = 0x24,
                        kTransfer2 = 0x28, kMaxTrailer = 0x2c;
constexpr std::uint64_t kLargestPayload = 256 << 20;

}  // namespace

U3vRangefinder::U3vRangefinder(UsbOpener open, U3vRangefinderOptions options)
    : open_(std::move(open)), options_(std::move(options)), info_{"rangefinder",        "u3v", "", "",
                                                                  DeviceState::kAbsent, ""} {
  memory_.read = [this](std::uint64_t address, std::size_t count) { return control_->Read(address, count); };
  memory_.write = [this](std::uint64_t address, std::span<const std::uint8_t> data) { control_->Write(address, data); };
  if (options_.sensor) sensor_ = *options_.sensor;
  try {
    Open();
  } catch (const DeviceError&) {
    if (!options_.may_be_absent) throw;  // else info_ says what is the matter
  }
  watch_ = std::jthread([this](std::stop_token stop) { Watch(stop); });
}

U3vRangefinder::~U3vRangefinder() {
  watch_ = {};
  Disarm();
}

void U3vRangefinder::Open() {
  NotingFault(info_mutex_, info_, [this] {
    control_.reset();
    port_.reset();
    port_ = open_();
  });
  BringUp();
}

// A camera that is unplugged while nobody asks it anything is noticed here.
void U3vRangefinder::Watch(std::stop_token stop) {
  std::mutex mutex;
  std::condition_variable_any never;
  std::unique_lock lock(mutex);
  while (!never.wait_for(lock, stop, options_.watch_period, [] { return false; }) && !stop.stop_requested()) {
    {
      const std::unique_lock call(call_mutex_, std::try_to_lock);
      if (!call.owns_lock() || !port_ || port_->Present()) continue;
      const std::lock_guard info_lock(info_mutex_);
      if (info_.state != DeviceState::kIdle && info_.state != DeviceState::kArmed) continue;
      info_.state = DeviceState::kAbsent;
      info_.fault = "camera: watch: it is unplugged. Plug it in and reset the station";
    }
    signal_.Tell();
  }
}

DeviceInfo U3vRangefinder::info() const {
  const std::lock_guard lock(info_mutex_);
  return info_;
}

bool U3vRangefinder::Has(const char* feature) const { return description_->Available(feature, memory_); }

void U3vRangefinder::SetIfPresent(const char* feature, const char* entry) {
  if (Has(feature)) description_->WriteEnumeration(feature, entry, memory_);
}

void U3vRangefinder::BringUp() {
  NotingFault(info_mutex_, info_, [this] {
    control_ = std::make_unique<u3v::ControlChannel>(*port_, options_.control);
    control_->Negotiate();
    ReadDescription();
    // The host before this one may have died with the stream on.
    StopStream();
    ReadSensor();
  });
  const std::lock_guard lock(info_mutex_);
  info_ = {"rangefinder", "u3v", port_->model(), port_->identity(), DeviceState::kIdle, ""};
}

void U3vRangefinder::ReadDescription() {
  const std::uint64_t manifest = control_->Read64(kManifestAddress);
  const std::uint64_t entries = control_->Read64(manifest);
  if (entries == 0 || entries > 64) {
    throw DeviceError(kName, "read description", "its manifest has " + std::to_string(entries) + " entries");
  }
  const u3v::Bytes entry = control_->Read(manifest + 8, kManifestEntry);
  const std::uint32_t schema = (ReadLittleEndian<std::uint32_t>(entry, 4) >> 10) & 0x3f;
  const std::uint64_t address = ReadLittleEndian<std::uint64_t>(entry, 8);
  const std::uint64_t size = ReadLittleEndian<std::uint64_t>(entry, 16);
  if (schema > 1 || size == 0 || size > kLargestDescription) {
    throw DeviceError(kName, "read description", "file type " + std::to_string(schema) + " of " + std::to_string(size) +
                                                     " bytes is not understood");
  }
  const u3v::Bytes file = control_->Read(address, size);
  const std::string text = schema == 1 ? UnzipFirstFile(file) : std::string(file.begin(), file.end());
  description_ = std::make_unique<genicam::Description>(text);
}

void U3vRangefinder::StopStream() {
  stream_.reset();
  if (description_->Has("AcquisitionStop")) description_->Execute("AcquisitionStop", memory_);
  if (Has("TLParamsLocked")) description_->WriteInteger("TLParamsLocked", 0, memory_);
  control_->Write32(control_->stream_registers() + kStreamControl, 0);
  const UsbPort::Status status = port_->ResetStream();
  if (status != UsbPort::Status::kOk) {
    throw DeviceError(kName, "reset stream", std::string(UsbStatusWords(status)));
  }
}

void U3vRangefinder::ReadSensor() {
  if (options_.sensor) {
    sensor_ = *options_.sensor;
    return;
  }
  if (!Has("Scan3dFocalLength")) {
    throw DeviceError(kName, "read projection", "the camera does not say its focal length",
                      "Give the sensor's projection in the configuration");
  }
  sensor_ = {};
  sensor_.columns = static_cast<int>(description_->ReadInteger("Width", memory_));
  sensor_.rows = static_cast<int>(description_->ReadInteger("Height", memory_));
  sensor_.focal_u = sensor_.focal_v = description_->ReadFloat("Scan3dFocalLength", memory_);
  sensor_.center_u = description_->ReadFloat("Scan3dPrincipalPointU", memory_);
  sensor_.center_v = description_->ReadFloat("Scan3dPrincipalPointV", memory_);
  sensor_.depth_noise = options_.depth_noise;
  const double metres = Metres();
  sensor_.min_depth = ReadFloatOr("Scan3dAxisMin", 0.0) * metres;
  if (Has("Scan3dAxisMax")) sensor_.max_depth = description_->ReadFloat("Scan3dAxisMax", memory_) * metres;
}

double U3vRangefinder::ReadFloatOr(const char* feature, double otherwise) const {
  return Has(feature) ? description_->ReadFloat(feature, memory_) : otherwise;
}

double U3vRangefinder::Metres() const {
  if (!Has("Scan3dDistanceUnit")) return 0.001;
  const std::string unit = description_->ReadEnumeration("Scan3dDistanceUnit", memory_);
  if (unit == "Millimeter") return 0.001;
  if (unit == "Inch") return 0.0254;
  throw DeviceError(kName, "read scale", "its unit of distance is " + unit, "Set the camera to millimetres");
}

// After the pixel format is set: cameras have another scale for each.
void U3vRangefinder::ReadScale() {
  SetIfPresent("Scan3dCoordinateSelector", "CoordinateC");
  scale_ = {};
  scale_.metres = Metres();
  scale_.scale = ReadFloatOr("Scan3dCoordinateScale", 1.0);
  scale_.offset = ReadFloatOr("Scan3dCoordinateOffset", 0.0);
  if (!std::isfinite(scale_.scale) || scale_.scale == 0.0 || !std::isfinite(scale_.offset)) {
    throw DeviceError(kName, "read scale", "scale " + std::to_string(scale_.scale) + ", offset " +
                                               std::to_string(scale_.offset) + " make no depth");
  }
  const bool flag = !Has("Scan3dInvalidDataFlag") || description_->ReadInteger("Scan3dInvalidDataFlag", memory_) != 0;
  if (flag && Has("Scan3dInvalidDataValue")) {
    scale_.invalid = description_->ReadFloat("Scan3dInvalidDataValue", memory_);
  }
}

void U3vRangefinder::StartStream() {
  const std::uint64_t base = control_->stream_registers();
  const std::uint32_t exponent = control_->Read32(base + kInfo) >> 24;
  const std::uint64_t payload = control_->Read64(base + kPayload);
  if (exponent > 20 || payload == 0 || payload > kLargestPayload) {
    throw DeviceError(kName, "arm", "it wants images of " + std::to_string(payload) + " bytes, aligned to 2^" +
                                        std::to_string(exponent));
  }
  const u3v::StreamLayout layout = u3v::PlanStream(payload, control_->Read32(base + kLeader),
                                                   control_->Read32(base + kTrailer), std::size_t{1} << exponent);
  control_->Write32(base + kMaxLeader, static_cast<std::uint32_t>(layout.leader));
  control_->Write32(base + kMaxTrailer, static_cast<std::uint32_t>(layout.trailer));
  control_->Write32(base + kTransferSize, static_cast<std::uint32_t>(layout.transfer));
  control_->Write32(base + kTransferCount, static_cast<std::uint32_t>(layout.transfers));
  control_->Write32(base + kTransfer1, static_cast<std::uint32_t>(layout.last_transfer));
  control_->Write32(base + kTransfer2, 0);
  stream_ = std::make_unique<u3v::StreamReader>(*port_, layout);
  stream_->Start();
  control_->Write32(base + kStreamControl, 1);
}

void U3vRangefinder::Arm() {
  const std::lock_guard call(call_mutex_);
  {
    const std::lock_guard lock(info_mutex_);
    if (info_.state == DeviceState::kFault || info_.state == DeviceState::kAbsent) {
      throw DeviceError(kName, "arm", "it failed before: " + info_.fault, "Reset the station");
    }
  }
  NotingFault(info_mutex_, info_, [this] {
    StopStream();
    const genicam::Description& camera = *description_;
    camera.WriteInteger("Width", sensor_.columns, memory_);
    camera.WriteInteger("Height", sensor_.rows, memory_);
    camera.WriteEnumeration("PixelFormat", options_.pixel_format, memory_);
    ReadScale();
    if (options_.exposure_us) camera.WriteFloat("ExposureTime", *options_.exposure_us, memory_);
    SetIfPresent("AcquisitionMode", "Continuous");
    SetIfPresent("TriggerSelector", "FrameStart");
    using Trigger = U3vRangefinderOptions::Trigger;
    camera.WriteEnumeration("TriggerMode", options_.trigger == Trigger::kNone ? "Off" : "On", memory_);
    if (options_.trigger == Trigger::kSoftware) camera.WriteEnumeration("TriggerSource", "Software", memory_);
    if (options_.trigger == Trigger::kWire) {
      camera.WriteEnumeration("TriggerSource", options_.trigger_line, memory_);
      SetIfPresent("TriggerActivation", "RisingEdge");
    }
    StartStream();
    if (Has("TLParamsLocked")) camera.WriteInteger("TLParamsLocked", 1, memory_);
    camera.Execute("AcquisitionStart", memory_);
  });
  const std::lock_guard lock(info_mutex_);
  info_.state = DeviceState::kArmed;
}

void U3vRangefinder::Trigger() {
  const std::lock_guard call(call_mutex_);
  if (options_.trigger != U3vRangefinderOptions::Trigger::kSoftware) return;
  if (!stream_) throw DeviceError(kName, "trigger", "it is not armed", "Arm it first");
  NotingFault(info_mutex_, info_, [this] {
    stream_->DiscardWaiting();  // a trigger that was sent twice leaves an image too many
    description_->Execute("TriggerSoftware", memory_);
  });
}

Exposure U3vRangefinder::Read(std::chrono::milliseconds timeout, std::stop_token stop) {
  const std::lock_guard call(call_mutex_);
  if (!stream_) throw DeviceError(kName, "read image", "it is not armed", "Arm it first");
  return NotingFault(info_mutex_, info_, [&] {
    u3v::Frame frame;
    try {
      frame = stream_->Next(timeout, stop);
    } catch (const TimeoutError&) {
      throw;
    } catch (const DeviceError&) {
      // A stall costs the image but not the stream: clear it, and where we can ask for the image again, do so once.
      const bool again = stream_->last_status() == UsbPort::Status::kStall &&
                         options_.trigger == U3vRangefinderOptions::Trigger::kSoftware;
      if (!again || port_->ResetStream() != UsbPort::Status::kOk) throw;
      stream_->Start();
      description_->Execute("TriggerSoftware", memory_);
      frame = stream_->Next(timeout, stop);
    }
    Exposure exposure;
    exposure.timestamp = std::chrono::nanoseconds(frame.leader.timestamp_ns);
    const auto columns = static_cast<int>(frame.leader.width), rows = static_cast<int>(frame.trailer.height);
    if (columns != sensor_.columns || rows != sensor_.rows) {
      throw DeviceError(kName, "read image",
                        "an image of " + std::to_string(columns) + " x " + std::to_string(rows) + " pixels where " +
                            std::to_string(sensor_.columns) + " x " + std::to_string(sensor_.rows) + " were due");
    }
    exposure.image = u3v::DecodeDepth(frame, scale_, {0.5 * sensor_.min_depth, 1.5 * sensor_.max_depth});
    stream_->GiveBack(std::move(frame));
    return exposure;
  });
}

void U3vRangefinder::Disarm() noexcept {
  const std::lock_guard call(call_mutex_);
  if (!stream_) return;
  try {
    NotingFault(info_mutex_, info_, [this] { StopStream(); });
    const std::lock_guard lock(info_mutex_);
    if (info_.state == DeviceState::kArmed) info_.state = DeviceState::kIdle;
  } catch (...) {
    // NotingFault has noted it; Reset mends it.
  }
}

void U3vRangefinder::Reset() {
  const std::lock_guard call(call_mutex_);
  stream_.reset();
  const bool absent = info().state == DeviceState::kAbsent;
  if (port_ && !absent) {
    try {
      BringUp();
      return;
    } catch (const DeviceError&) {
      // Harder: the whole device, and open it anew.
      port_->ResetDevice();
    }
  }
  Open();
}

}  // namespace geond::drivers
