// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "drivers/usb_port.h"

namespace geond::drivers {

// Opens a U3V compatible camera through libusb: any device whose interfaces are of that class, whoever made it. With
// `identity` (GUID or serial number) that one; empty: the only one there is. Throws DeviceError saying what was found,
// and what to do if it may not be opened.
UsbOpener LibusbCamera(std::string identity);

// The same for a SICK TiM line scanner; its one channel each way is the port's control channel.
UsbOpener LibusbScanner(std::string serial);

}  // namespace geond::drivers
