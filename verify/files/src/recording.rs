//! Recordings as robots keep them: MCAP files with messages of ROS 2.

mod messages;

use super::FileError;
use finray_imaging::RgbRows;
use finray_model::Vector;
use mcap::records::MessageHeader;
use messages::{IMAGE, STRING, WRENCH_STAMPED, string, wrench_stamped, write_image};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

/// Topic of the lines of JSON.
const LINE_TOPIC: &str = "/finray/live";
/// Topic of the images.
const IMAGE_TOPIC: &str = "/finray/image";
/// Frame of the images.
const CAMERA_FRAME: &str = "camera";

/// An MCAP file that receives messages one after another. Each message is in the file as soon as it is written, so the messages of a recording that
/// was interrupted can be read up to the last.
pub struct Recording {
    writer: mcap::Writer<BufWriter<File>>,
    path: PathBuf,
    line_channel: u16,
    wrench_schema: u16,
    /// Channels of wrenches by topic.
    wrench_channels: Vec<(String, u16)>,
    /// Channel of the images. `None` before the first image.
    image_channel: Option<u16>,
    /// Memory for the message of an image.
    image_bytes: Vec<u8>,
    /// Number of messages.
    count: u32,
}

/// A force at a contact of a finger.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactForce {
    /// Name of the finger; empty for the only finger.
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
            // Chunks would keep the last messages in memory.
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
        let (wrench_channels, image_bytes) = (Vec::new(), Vec::new());
        Ok(Recording {
            writer,
            path,
            line_channel,
            wrench_schema,
            wrench_channels,
            image_channel: None,
            image_bytes,
            count: 0,
        })
    }

    /// Writes the image of a frame if it is given, the line of the frame, and the force at each contact as a `WrenchStamped` on the topic
    /// `/finray/FINGER/contact_N`. The frame of the wrench, `FINGER_contact_N`, has the axes of the finger frame and its origin at the contact; the
    /// torque is zero. The time of publication and the stamp are `time_s` (s), or the present time if `time_s` is `None`. The time of logging is the
    /// present time.
    ///
    /// # Errors
    /// [`FileError::Unwritable`].
    pub fn add(
        &mut self,
        time_s: Option<f64>,
        image: Option<&dyn RgbRows>,
        line: &str,
        forces: &[ContactForce],
    ) -> Result<(), FileError> {
        let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        let stamp = time_s.map_or(now, |time_s| Duration::try_from_secs_f64(time_s).unwrap_or_default());
        if let Some(image) = image {
            let channel = self.image_channel()?;
            let mut bytes = std::mem::take(&mut self.image_bytes);
            write_image(&mut bytes, stamp, CAMERA_FRAME, image);
            let written = self.write(channel, [now, stamp], &bytes);
            self.image_bytes = bytes;
            written?;
        }
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

    fn image_channel(&mut self) -> Result<u16, FileError> {
        if let Some(channel) = self.image_channel {
            return Ok(channel);
        }
        let mut add = || {
            let schema = self.writer.add_schema("sensor_msgs/msg/Image", "ros2msg", IMAGE.as_bytes())?;
            self.writer.add_channel(schema, IMAGE_TOPIC, "cdr", &BTreeMap::new())
        };
        let channel = add().map_err(|error| unwritable(&self.path, error))?;
        self.image_channel = Some(channel);
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
