//! Messages of ROS 2 in CDR, the OMG Common Data Representation, and their definitions.

use finray_imaging::RgbRows;
use finray_model::Vector;
use std::time::Duration;

/// Definitions of `std_msgs/msg/Header` and of the message in it, as they follow the definition of a message that contains a header.
macro_rules! header {
    () => {
        "\
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"
    };
}

/// Definition of `geometry_msgs/msg/WrenchStamped` and of the messages in it, as ROS 2 records it.
pub(super) const WRENCH_STAMPED: &str = concat!(
    "std_msgs/Header header\ngeometry_msgs/Wrench wrench\n",
    header!(),
    "\
================================================================================
MSG: geometry_msgs/Wrench
geometry_msgs/Vector3 force
geometry_msgs/Vector3 torque
================================================================================
MSG: geometry_msgs/Vector3
float64 x
float64 y
float64 z
"
);
/// Definition of `sensor_msgs/msg/Image` and of the messages in it, as ROS 2 records it, without its comments.
pub(super) const IMAGE: &str = concat!(
    "\
std_msgs/Header header
uint32 height
uint32 width
string encoding
uint8 is_bigendian
uint32 step
uint8[] data
",
    header!()
);
/// Definition of `std_msgs/msg/String`, which contains a line of JSON. Programs that read ROS 2 recordings reject channels with other encodings.
pub(super) const STRING: &str = "string data\n";
/// First bytes of a message in CDR (OMG Common Data Representation): its numbers are little-endian.
const CDR: [u8; 4] = [0, 1, 0, 0];

/// Fills up with zeros to a multiple of `size` bytes, counted after the first four bytes. Numbers begin at a multiple of their size.
fn align(bytes: &mut Vec<u8>, size: usize) {
    bytes.resize(CDR.len() + (bytes.len() - CDR.len()).next_multiple_of(size), 0);
}

/// Appends the header of a message: stamp and frame.
fn push_header(bytes: &mut Vec<u8>, stamp: Duration, frame_id: &str) {
    // After the year 2038, the seconds no longer fit into this message.
    bytes.extend(i32::try_from(stamp.as_secs()).unwrap_or(i32::MAX).to_le_bytes());
    bytes.extend(stamp.subsec_nanos().to_le_bytes());
    push_string(bytes, frame_id);
}

/// Appends a string in CDR: length, bytes and a zero byte. The string must begin at a multiple of four bytes.
fn push_string(bytes: &mut Vec<u8>, text: &str) {
    bytes.extend((text.len() as u32 + 1).to_le_bytes());
    bytes.extend(text.bytes().chain([0]));
}

/// A `String` in CDR.
pub(super) fn string(text: &str) -> Vec<u8> {
    let mut bytes = CDR.to_vec();
    push_string(&mut bytes, text);
    bytes
}

/// A `WrenchStamped` in CDR.
pub(super) fn wrench_stamped(stamp: Duration, frame_id: &str, force: Vector) -> Vec<u8> {
    let mut bytes = CDR.to_vec();
    push_header(&mut bytes, stamp, frame_id);
    align(&mut bytes, 8);
    for number in [force.x, force.y, 0.0, 0.0, 0.0, 0.0] {
        bytes.extend(number.to_le_bytes());
    }
    bytes
}

/// Writes an `Image` in CDR to `bytes`: red, green and blue of each pixel, row by row. The old content of `bytes` is lost.
pub(super) fn write_image(bytes: &mut Vec<u8>, stamp: Duration, frame_id: &str, image: &dyn RgbRows) {
    let [width, height] = image.size_px();
    bytes.clear();
    bytes.extend(CDR);
    push_header(bytes, stamp, frame_id);
    align(bytes, 4);
    bytes.extend([height, width].into_iter().flat_map(u32::to_le_bytes));
    push_string(bytes, "rgb8");
    let is_big_endian = 0;
    bytes.push(is_big_endian);
    align(bytes, 4);
    bytes.extend([3 * width, 3 * width * height].into_iter().flat_map(u32::to_le_bytes));
    let mut buffer = Vec::new();
    for row in 0..height as usize {
        bytes.extend_from_slice(image.row(row, 0..width as usize, &mut buffer));
    }
}
