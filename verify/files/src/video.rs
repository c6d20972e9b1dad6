//! Video files of any format, decoded by the program `ffmpeg`.

use std::io::{self, ErrorKind, Read};
use std::path::Path;
use std::process::{Child, ChildStdout, Command, Stdio};
use std::thread::{self, JoinHandle};

/// Frames of a video file as a YUV4MPEG2 stream, written by `ffmpeg` while they are read. `ffmpeg` rotates frames as the file asks, repeats or drops
/// frames of a variable rate so that the rate of the stream holds, and converts colours to those of ITU-R BT.601 with a limited range, which
/// [`FrameReader`](crate::frames::FrameReader) expects.
///
/// Reads are not buffered. The end of the stream is an error if `ffmpeg` failed.
pub struct DecodedVideo {
    decoder: Child,
    stream: ChildStdout,
    /// Reads the messages of `ffmpeg` and returns the last line.
    messages: Option<JoinHandle<String>>,
}

impl DecodedVideo {
    /// Starts to decode a file.
    ///
    /// # Errors
    /// [`io::Error`] if `ffmpeg` is not found or cannot be started.
    pub fn open(path: &Path) -> io::Result<DecodedVideo> {
        // With the prefix, a name is neither an option nor a protocol.
        let mut file = std::ffi::OsString::from("file:");
        file.push(path);
        let decoder = Command::new("ffmpeg")
            .args(["-nostdin", "-v", "error", "-i"])
            .arg(file)
            .args(["-map", "0:v:0", "-vf", "scale=out_color_matrix=bt601:out_range=limited"])
            .args(["-pix_fmt", "yuv420p", "-f", "yuv4mpegpipe", "-"])
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn();
        let mut decoder = decoder.map_err(|error| match error.kind() {
            ErrorKind::NotFound => io::Error::new(
                ErrorKind::NotFound,
                "only the program ffmpeg decodes this video, and no ffmpeg is on the PATH",
            ),
            _ => error,
        })?;
        let (Some(stream), Some(mut messages)) = (decoder.stdout.take(), decoder.stderr.take()) else {
            return Err(io::Error::other("ffmpeg has no output"));
        };
        let last_line = move || {
            let mut text = Vec::new();
            // Messages that cannot be read are as good as none.
            let _ = messages.read_to_end(&mut text);
            let text = String::from_utf8_lossy(&text);
            text.lines().rev().find(|line| !line.trim().is_empty()).unwrap_or("no message").to_owned()
        };
        let messages = Some(thread::Builder::new().spawn(last_line)?);
        Ok(DecodedVideo { decoder, stream, messages })
    }
}

impl Read for DecodedVideo {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.stream.read(buffer)?;
        if count > 0 || buffer.is_empty() || self.decoder.wait()?.success() {
            return Ok(count);
        }
        let message = self.messages.take().and_then(|messages| messages.join().ok());
        Err(io::Error::other(format!("ffmpeg: {}", message.unwrap_or_default())))
    }
}

impl Drop for DecodedVideo {
    /// Ends `ffmpeg` if the stream is not read to its end.
    fn drop(&mut self) {
        let _ = self.decoder.kill();
        let _ = self.decoder.wait();
    }
}
