// SPDX-License-Identifier: Apache-2.0
#include <sstream>
#include <utility>
#include <vector>

#include "sim/fake_camera.h"
#include "sim/fake_camera_registers.h"

namespace geond::sim {
namespace {

class Writer {
 public:
  explicit Writer(std::uint64_t base) : base_(base) {}

  void Register(const char* kind, const std::string& name, std::uint64_t address, int length, const char* mode) {
    text_ << "<" << kind << " Name=\"" << name << "\"><Address>" << base_ + address << "</Address><Length>" << length
          << "</Length><AccessMode>" << mode << "</AccessMode><pPort>Device</pPort><Cachable>NoCache</Cachable>";
    if (kind == std::string("IntReg")) text_ << "<Sign>Unsigned</Sign>";
    text_ << "<Endianess>LittleEndian</Endianess></" << kind << ">\n";
  }
  void Integer(const std::string& name, std::uint64_t address, const char* mode, const std::string& range = {}) {
    text_ << "<Integer Name=\"" << name << "\"><pValue>" << name << "Reg</pValue>" << range << "</Integer>\n";
    Register("IntReg", name + "Reg", address, 4, mode);
  }
  void Float(const std::string& name, std::uint64_t address) {
    text_ << "<Float Name=\"" << name << "\"><pValue>" << name << "Reg</pValue></Float>\n";
    Register("FloatReg", name + "Reg", address, 8, "RO");
  }
  void Enumeration(const std::string& name, std::uint64_t address,
                   const std::vector<std::pair<const char*, std::uint32_t>>& entries) {
    text_ << "<Enumeration Name=\"" << name << "\">";
    for (const auto& [entry, value] : entries) {
      text_ << "<EnumEntry Name=\"" << entry << "\"><Value>" << value << "</Value></EnumEntry>";
    }
    text_ << "<pValue>" << name << "Reg</pValue></Enumeration>\n";
    Register("IntReg", name + "Reg", address, 4, "RW");
  }
  void Command(const std::string& name, const std::string& target, int value) {
    text_ << "<Command Name=\"" << name << "\"><pValue>" << target << "</pValue><CommandValue>" << value
          << "</CommandValue></Command>\n";
  }
  void Text(const std::string& name, std::uint64_t address) {
    text_ << "<StringReg Name=\"" << name << "\"><Address>" << address
          << "</Address><Length>64</Length><AccessMode>RO</AccessMode><pPort>Device</pPort></StringReg>\n";
  }
  std::ostringstream& text() { return text_; }

 private:
  const std::uint64_t base_;
  std::ostringstream text_;
};

}  // namespace

std::string FakeCameraDescription(std::uint64_t base, const SensorModel& sensor) {
  using namespace fake_camera;
  Writer out(base);
  out.text() << R"(<?xml version="1.0" encoding="utf-8"?>
<RegisterDescription ModelName="FakeRange" VendorName="geond" StandardNameSpace="None" SchemaMajorVersion="1" SchemaMinorVersion="1" SchemaSubMinorVersion="0" MajorVersion="1" MinorVersion="0" SubMinorVersion="0" ToolTip="" ProductGuid="0" VersionGuid="0" xmlns="http://www.genicam.org/GenApi/Version_1_1">
<Category Name="Root"><pFeature>Width</pFeature><pFeature>Height</pFeature><pFeature>PixelFormat</pFeature><pFeature>PayloadSize</pFeature><pFeature>AcquisitionMode</pFeature><pFeature>AcquisitionStart</pFeature><pFeature>AcquisitionStop</pFeature><pFeature>TriggerMode</pFeature><pFeature>TriggerSource</pFeature><pFeature>TriggerSoftware</pFeature><pFeature>ExposureTime</pFeature><pFeature>DeviceModelName</pFeature></Category>
)";
  out.Text("DeviceVendorName", 0x04);
  out.Text("DeviceModelName", 0x44);
  out.Text("DeviceSerialNumber", 0x144);
  out.Integer("Width", kWidth, "RW", "<Min>1</Min><Max>" + std::to_string(sensor.columns) + "</Max><Inc>1</Inc>");
  out.Integer("Height", kHeight, "RW", "<Min>1</Min><Max>" + std::to_string(sensor.rows) + "</Max><Inc>1</Inc>");
  out.Integer("PayloadSize", kPayloadSize, "RO");
  out.Integer("TLParamsLocked", kLocked, "RW", "<Min>0</Min><Max>1</Max>");
  out.Enumeration("PixelFormat", kPixelFormat,
                  {{"Coord3D_C16", 0x011000B8},
                   {"Coord3D_C32f", 0x012000BF},
                   {"Coord3D_ABC16", 0x023000B9},
                   {"Coord3D_ABC32f", 0x026000C0}});
  out.Enumeration("AcquisitionMode", kAcquisitionMode, {{"Continuous", 0}});
  out.Enumeration("TriggerSelector", kTriggerSelector, {{"FrameStart", 0}});
  out.Enumeration("TriggerMode", kTriggerMode, {{"Off", 0}, {"On", 1}});
  out.Enumeration("TriggerSource", kTriggerSource, {{"Software", 0}, {"Line0", 1}});
  out.Enumeration("TriggerActivation", kTriggerActivation, {{"RisingEdge", 0}});
  out.Enumeration("Scan3dDistanceUnit", kDistanceUnit, {{"Millimeter", 0}, {"Inch", 1}});
  out.Register("IntReg", "AcquisitionReg", kAcquisition, 4, "RW");
  out.Command("AcquisitionStart", "AcquisitionReg", 1);
  out.Command("AcquisitionStop", "AcquisitionReg", 0);
  out.Register("IntReg", "TriggerSoftwareReg", kTriggerSoftware, 4, "RW");
  out.Command("TriggerSoftware", "TriggerSoftwareReg", 1);
  out.text()
      << R"(<Float Name="ExposureTime"><pValue>ExposureTicks</pValue><Min>1</Min><Max>1000000</Max><Unit>us</Unit></Float>
<Converter Name="ExposureTicks"><FormulaTo>FROM * 10</FormulaTo><FormulaFrom>TO / 10</FormulaFrom><pValue>ExposureReg</pValue></Converter>
)";
  out.Register("IntReg", "ExposureReg", kExposureTicks, 4, "RW");
  out.Integer("Scan3dInvalidDataFlag", kInvalidFlag, "RO");
  out.Float("Scan3dCoordinateScale", kScale);
  out.Float("Scan3dCoordinateOffset", kOffset);
  out.Float("Scan3dInvalidDataValue", kInvalidValue);
  out.Float("Scan3dFocalLength", kFocalLength);
  out.Float("Scan3dPrincipalPointU", kPrincipalU);
  out.Float("Scan3dPrincipalPointV", kPrincipalV);
  out.Float("Scan3dAxisMin", kAxisMin);
  out.Float("Scan3dAxisMax", kAxisMax);
  out.text() << "<Port Name=\"Device\"/>\n</RegisterDescription>\n";
  return out.text().str();
}

}  // namespace geond::sim
