//! Recordings as robots keep them: MCAP files with messages of ROS 2.

use super::FileError;
use finray_model::Vector;
use mcap::records::MessageHeader;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

/// Definition of `geometry_msgs/msg/WrenchStamped` and of the messages in it, in the form in which ROS 2 records definitions.
const WRENCH_STAMPED: &str = "\
std_msgs/Header header
geometry_msgs/Wrench wrench
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
================================================================================
MSG: geometry_msgs/Wrench
geometry_msgs/Vector3 force
geometry_msgs/Vector3 torque
================================================================================
MSG: geometry_msgs/Vector3
float64 x
float64 y
float64 z
";
/// Definition of `std_msgs/msg/String`; a message of this type contains a line of JSON. The line is sent in CDR encoding, because programs that read
/// ROS 2 recordings reject channels with other encodings.
const STRING: &str = "string data\n";
/// Topic of the lines of JSON.
const LINE_TOPIC: &str = "/finray/live";

/// An MCAP file that receives messages one after another. Each message is in the file as soon as it is written, so an interrupted recording can be
/// read up to its last message.
pub struct Recording {
    writer: mcap::Writer<BufWriter<File>>,
    path: PathBuf,
    line_channel: u16,
    wrench_schema: u16,
    /// Channels of wrenches by topic.
    wrench_channels: Vec<(String, u16)>,
    /// Number of messages.
    count: u32,
}

/// A force at a contact of a finger.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactForce {
    /// Name of the finger; empty if there is only one finger.
    pub finger: String,
    /// Number of the contact, from 1.
    pub contact: usize,
    /// Force on the finger, N, in the finger frame.
    pub force: Vector,
}

impl Recording {
    /// Creates the file, or overwrites it.
    ///
    /// # Errors
    /// [`FileError::Unwritable`].
    pub fn create(path: &Path) -> Result<Recording, FileError> {
        let file = File::create(path).map_err(|reason| FileError::Unwritable { path: path.to_owned(), reason })?;
        let begin = || {
            // The file has no chunks, because chunks would keep the last messages in memory.
            let options =
                mcap::WriteOptions::new().compression(None).use_chunks(false).profile("ros2").library("finray");
            let mut writer = options.create(BufWriter::new(file))?;
            let wrench_schema =
                writer.add_schema("geometry_msgs/msg/WrenchStamped", "ros2msg", WRENCH_STAMPED.as_bytes())?;
            let line_schema = writer.add_schema("std_msgs/msg/String", "ros2msg", STRING.as_bytes())?;
            let line_channel = writer.add_channel(line_schema, LINE_TOPIC, "cdr", &BTreeMap::new())?;
            Ok((writer, wrench_schema, line_channel))
        };
        let (writer, wrench_schema, line_channel) = begin().map_err(|error| unwritable(path, error))?;
        let path = path.to_owned();
        Ok(Recording { writer, path, line_channel, wrench_schema, wrench_channels: Vec::new(), count: 0 })
    }

    /// Writes the line of a frame, and the force at each contact as a `WrenchStamped` on the topic `/finray/FINGER/contact_N`. The frame of the
    /// wrench, `FINGER_contact_N`, has the axes of the finger frame and its origin at the contact; the torque is zero. The time of publication and
    /// the stamp are `time_s` (s), or the present time if `time_s` is `None`. The time of logging is the present time.
    ///
    /// # Errors
    /// [`FileError::Unwritable`].
    pub fn add(&mut self, time_s: Option<f64>, line: &str, forces: &[ContactForce]) -> Result<(), FileError> {
        let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        let stamp = time_s.map_or(now, |time_s| Duration::try_from_secs_f64(time_s).unwrap_or_default());
        self.write(self.line_channel, [now, stamp], &string(line))?;
        for force in forces {
            let ContactForce { finger, contact, force } = force;
            let [topic, frame_id] = match finger.is_empty() {
                true => [format!("/finray/contact_{contact}"), format!("contact_{contact}")],
                false => [format!("/finray/{finger}/contact_{contact}"), format!("{finger}_contact_{contact}")],
            };
            let channel = self.wrench_channel(topic)?;
            self.write(channel, [now, stamp], &wrench_stamped(stamp, &frame_id, *force))?;
        }
        self.writer.flush().map_err(|error| unwritable(&self.path, error))
    }

    /// Ends the file with its index.
    ///
    /// # Errors
    /// [`FileError::Unwritable`].
    pub fn finish(mut self) -> Result<(), FileError> {
        self.writer.finish().map(|_| ()).map_err(|error| unwritable(&self.path, error))
    }

    fn wrench_channel(&mut self, topic: String) -> Result<u16, FileError> {
        if let Some((_, channel)) = self.wrench_channels.iter().find(|(known, _)| *known == topic) {
            return Ok(*channel);
        }
        let added = self.writer.add_channel(self.wrench_schema, &topic, "cdr", &BTreeMap::new());
        let channel = added.map_err(|error| unwritable(&self.path, error))?;
        self.wrench_channels.push((topic, channel));
        Ok(channel)
    }

    fn write(&mut self, channel_id: u16, [now, stamp]: [Duration; 2], bytes: &[u8]) -> Result<(), FileError> {
        let [log_time, publish_time] = [now, stamp].map(|time| u64::try_from(time.as_nanos()).unwrap_or(u64::MAX));
        let header = MessageHeader { channel_id, sequence: self.count, log_time, publish_time };
        self.count = self.count.wrapping_add(1);
        self.writer.write_to_known_channel(&header, bytes).map_err(|error| unwritable(&self.path, error))
    }
}

fn unwritable(path: &Path, error: mcap::McapError) -> FileError {
    let reason = match error {
        mcap::McapError::Io(reason) => reason,
        other => std::io::Error::other(other),
    };
    FileError::Unwritable { path: path.to_owned(), reason }
}

/// First bytes of a message in CDR (OMG Common Data Representation); they state that its numbers are little-endian.
const CDR: [u8; 4] = [0, 1, 0, 0];

/// Appends a string in CDR: length, bytes and a zero byte. The string must begin at a multiple of four bytes.
fn push_string(bytes: &mut Vec<u8>, text: &str) {
    bytes.extend((text.len() as u32 + 1).to_le_bytes());
    bytes.extend(text.bytes().chain([0]));
}

/// A `String` in CDR.
fn string(text: &str) -> Vec<u8> {
    let mut bytes = CDR.to_vec();
    push_string(&mut bytes, text);
    bytes
}

/// A `WrenchStamped` in CDR. Each number starts at a multiple of its size, counted from the end of the first four bytes.
fn wrench_stamped(stamp: Duration, frame_id: &str, force: Vector) -> Vec<u8> {
    let mut bytes = CDR.to_vec();
    // After the year 2038, the seconds exceed the 32-bit integer of this message.
    bytes.extend(i32::try_from(stamp.as_secs()).unwrap_or(i32::MAX).to_le_bytes());
    bytes.extend(stamp.subsec_nanos().to_le_bytes());
    push_string(&mut bytes, frame_id);
    bytes.resize(CDR.len() + (bytes.len() - CDR.len()).next_multiple_of(8), 0);
    for number in [force.x, force.y, 0.0, 0.0, 0.0, 0.0] {
        bytes.extend(number.to_le_bytes());
    }
    bytes
}
