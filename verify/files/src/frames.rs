//! Frames of a video stream: YUV4MPEG2, or raw RGB.

mod chroma;
mod writer;

pub use writer::FrameWriter;

use chroma::{ChromaPlanes, FINE, Siting};
use finray_imaging::RgbRows;
use std::io::{BufRead, ErrorKind, Read};
use std::ops::Range;

/// Longest header of a stream or frame, bytes.
const LONGEST_HEADER: u64 = 4096;
/// Largest width and height of a frame, px.
pub const LARGEST_SIDE_PX: u32 = 20_000;

/// Reason why a stream of frames cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum FrameError {
    /// The stream cannot be read.
    #[error("cannot be read: {0}")]
    Unreadable(#[from] std::io::Error),
    /// The format of the stream, according to its header, is not supported.
    #[error("{0}")]
    Header(String),
    /// The stream continues with something other than a frame.
    #[error(
        "frame {frame}: expected a line that begins with FRAME, found {found:?}; does the size of the frames change?"
    )]
    NotAFrame {
        /// Number of the frame, from 0.
        frame: usize,
        /// Beginning of the line.
        found: String,
    },
    /// The stream ends within a frame.
    #[error("frame {frame} is cut off: {found} of {expected} bytes")]
    CutOff {
        /// Number of the frame, from 0.
        frame: usize,
        /// Number of bytes found.
        found: usize,
        /// Number of bytes of a whole frame.
        expected: usize,
    },
}

/// Arrangement of the bytes of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Samples {
    /// Red, green and blue of each pixel.
    Rgb,
    /// A plane of luma, and two planes of chroma with the siting of their samples across and down. `None` for luma without chroma.
    Yuv(Option<[Siting; 2]>),
}

/// Size, arrangement and rate of the frames of a stream.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrameLayout {
    /// Width and height, px.
    pub size_px: [u32; 2],
    /// Frames per second, if the stream states it.
    pub per_second: Option<f64>,
    samples: Samples,
    /// Whether luma and chroma use all values from 0 to 255. Without the full range, luma ranges from 16 to 235 and chroma from 16 to 240 (ITU-R
    /// BT.601).
    is_full_range: bool,
}

impl FrameLayout {
    /// Raw frames: red, green and blue of each pixel, row by row, without headers.
    pub fn rgb(size_px: [u32; 2]) -> FrameLayout {
        FrameLayout { size_px, per_second: None, samples: Samples::Rgb, is_full_range: true }
    }

    /// Layout from the header line of a YUV4MPEG2 stream.
    fn of_header(header: &str) -> Result<FrameLayout, FrameError> {
        let mut fields = header.split_ascii_whitespace();
        if fields.next() != Some("YUV4MPEG2") {
            return Err(FrameError::Header("expected a stream that begins with YUV4MPEG2".to_owned()));
        }
        let mut layout = FrameLayout {
            size_px: [0, 0],
            per_second: None,
            samples: Samples::Yuv(Some([Siting::Between; 2])),
            is_full_range: false,
        };
        // ffmpeg repeats the siting in XYSCSS, which decides where the colour space leaves the siting open.
        let (mut colour_space, mut subsampling) = ("420", None);
        for field in fields {
            let (key, value) = field.split_at_checked(1).unwrap_or((field, ""));
            match key {
                "W" => layout.size_px[0] = value.parse().unwrap_or(0),
                "H" => layout.size_px[1] = value.parse().unwrap_or(0),
                "F" => layout.per_second = rate(value),
                "C" => colour_space = value,
                "X" if value.starts_with("YSCSS=") => subsampling = value.strip_prefix("YSCSS="),
                "X" if value == "COLORRANGE=FULL" => layout.is_full_range = true,
                "I" if !matches!(value, "p" | "?") => {
                    return Err(FrameError::Header(format!("expected progressive frames (Ip), found I{value}")));
                }
                _ => {}
            }
        }
        let open = subsampling.filter(|_| colour_space == "420").map(str::to_ascii_lowercase);
        let known = open.and_then(|subsampling| samples(&subsampling).ok());
        layout.samples = known.map_or_else(|| samples(colour_space), Ok)?;
        match layout.size_px.iter().all(|side| (1..=LARGEST_SIDE_PX).contains(side)) {
            true => Ok(layout),
            false => Err(FrameError::Header(format!(
                "expected width and height (W, H) from 1 to {LARGEST_SIDE_PX} px in the header, found {header:?}"
            ))),
        }
    }

    /// Number of bytes in a frame, without its header.
    pub fn byte_count(&self) -> usize {
        let [width, height] = self.size_px.map(|px| px as usize);
        match self.samples {
            Samples::Rgb => 3 * width * height,
            Samples::Yuv(None) => width * height,
            Samples::Yuv(Some([across, down])) => width * height + 2 * across.count(width) * down.count(height),
        }
    }

    /// Converts a part of a row of a frame to red, green and blue of each pixel. Chroma samples that several pixels share are interpolated.
    ///
    /// # Panics
    /// Panics if `row` or `columns` are outside the frame, or if `bytes` are not those of a whole frame.
    ///
    /// # Reference
    /// ITU-R BT.601: R = Y + 1.402 Cr, G = Y - 0.344136 Cb - 0.714136 Cr, B = Y + 1.772 Cb.
    fn row<'p>(&self, bytes: &'p [u8], row: usize, columns: Range<usize>, buffer: &'p mut Vec<u8>) -> &'p [u8] {
        let [width, height] = self.size_px.map(|px| px as usize);
        let pixels = row * width + columns.start..row * width + columns.end;
        let Samples::Yuv(chroma) = self.samples else {
            return &bytes[3 * pixels.start..3 * pixels.end];
        };
        // Gain of luma (in units of 1/65536), value of luma for black, and gains of chroma (in units of 1/65536).
        let (gain, black, of_chroma) = if self.is_full_range {
            (65536, 0, [91881, -22554, -46802, 116130])
        } else {
            (76309, 16, [104597, -25675, -53279, 132201])
        };
        let luma = &bytes[pixels];
        let bright = |y: u8| gain * (i32::from(y) - black);
        buffer.resize(3 * luma.len(), 0);
        let Some(siting) = chroma else {
            buffer.chunks_exact_mut(3).zip(luma).for_each(|(pixel, y)| pixel.fill(byte(bright(*y))));
            return buffer;
        };
        let size = [siting[0].count(width), siting[1].count(height)];
        let (blue, red) = bytes[width * height..].split_at(size[0] * size[1]);
        let mut pixels = buffer.chunks_exact_mut(3).zip(luma);
        ChromaPlanes { planes: [blue, red], size, siting }.each(row, columns, |cb, cr| {
            let Some((pixel, y)) = pixels.next() else { return };
            let y = bright(*y);
            pixel[0] = byte(y + of_chroma[0] * cr / FINE);
            pixel[1] = byte(y + (of_chroma[1] * cb + of_chroma[2] * cr) / FINE);
            pixel[2] = byte(y + of_chroma[3] * cb / FINE);
        });
        buffer
    }
}

/// Converts a value in units of 1/65536 to a byte, limited to 0 to 255.
fn byte(value: i32) -> u8 {
    ((value + 32768) >> 16).clamp(0, 255) as u8
}

/// A frame of a stream; its pixels are converted to red, green and blue only when they are read.
#[derive(Debug, Clone)]
pub struct VideoFrame {
    layout: FrameLayout,
    /// The bytes of the frame, as in the stream.
    bytes: Vec<u8>,
}

impl VideoFrame {
    /// A frame without content, for [`FrameReader::read`].
    pub fn new(layout: FrameLayout) -> VideoFrame {
        VideoFrame { layout, bytes: vec![0; layout.byte_count()] }
    }
}

impl RgbRows for VideoFrame {
    fn size_px(&self) -> [u32; 2] {
        self.layout.size_px
    }

    fn row<'p>(&'p self, row: usize, columns: Range<usize>, buffer: &'p mut Vec<u8>) -> &'p [u8] {
        self.layout.row(&self.bytes, row, columns, buffer)
    }
}

/// Frames per second from `numerator:denominator`.
fn rate(value: &str) -> Option<f64> {
    let (numerator, denominator) = value.split_once(':')?;
    let rate = numerator.parse::<f64>().ok()? / denominator.parse::<f64>().ok()?;
    (rate > 0.0 && rate.is_finite()).then_some(rate)
}

fn samples(colour_space: &str) -> Result<Samples, FrameError> {
    match colour_space {
        "mono" => Ok(Samples::Yuv(None)),
        "420" | "420jpeg" => Ok(Samples::Yuv(Some([Siting::Between; 2]))),
        "420mpeg2" => Ok(Samples::Yuv(Some([Siting::First, Siting::Between]))),
        "420paldv" => Ok(Samples::Yuv(Some([Siting::First; 2]))),
        "422" => Ok(Samples::Yuv(Some([Siting::First, Siting::Each]))),
        "444" => Ok(Samples::Yuv(Some([Siting::Each; 2]))),
        other => Err(FrameError::Header(format!(
            "expected 8 bits a sample in the form C444, C422, C420 or Cmono, found C{other}; ffmpeg writes C444 with -pix_fmt yuv444p"
        ))),
    }
}

/// Reads the frames of a stream one after another.
pub struct FrameReader<R> {
    source: R,
    layout: FrameLayout,
    has_headers: bool,
    /// Number of frames read.
    frame: usize,
}

impl<R: BufRead> FrameReader<R> {
    /// A reader of a YUV4MPEG2 stream. Reads the header of the stream.
    ///
    /// # Errors
    /// [`FrameError`] for a stream of another format, or of an unsupported variant.
    pub fn yuv4mpeg2(mut source: R) -> Result<FrameReader<R>, FrameError> {
        let layout = FrameLayout::of_header(&header(&mut source)?.unwrap_or_default())?;
        Ok(FrameReader { source, layout, has_headers: true, frame: 0 })
    }

    /// A reader of a stream of raw frames.
    pub fn raw(source: R, layout: FrameLayout) -> FrameReader<R> {
        FrameReader { source, layout, has_headers: false, frame: 0 }
    }

    /// Layout of the frames.
    pub fn layout(&self) -> FrameLayout {
        self.layout
    }

    /// Reads the next frame into the memory of `frame`. Returns false at the end of the stream.
    ///
    /// # Errors
    /// [`FrameError`] if the stream cannot be read, ends within the frame, or continues with something other than a frame.
    pub fn read(&mut self, frame: &mut VideoFrame) -> Result<bool, FrameError> {
        let (number, expected) = (self.frame, self.layout.byte_count());
        if self.has_headers {
            let Some(line) = header(&mut self.source)? else { return Ok(false) };
            match line.split_ascii_whitespace().next() {
                Some("FRAME") => {}
                _ if "FRAME".starts_with(&line) && self.source.fill_buf()?.is_empty() => {
                    return Err(FrameError::CutOff { frame: number, found: 0, expected });
                }
                _ => return Err(FrameError::NotAFrame { frame: number, found: line.chars().take(40).collect() }),
            }
        }
        frame.layout = self.layout;
        frame.bytes.resize(expected, 0);
        match filled(&mut self.source, &mut frame.bytes)? {
            0 if !self.has_headers => Ok(false),
            found if found < expected => Err(FrameError::CutOff { frame: number, found, expected }),
            _ => {
                self.frame += 1;
                Ok(true)
            }
        }
    }
}

/// Reads until `bytes` are full or the source ends. Returns the number of bytes read.
fn filled(source: &mut impl Read, bytes: &mut [u8]) -> std::io::Result<usize> {
    let mut found = 0;
    while found < bytes.len() {
        match source.read(&mut bytes[found..]) {
            Ok(0) => break,
            Ok(count) => found += count,
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
    Ok(found)
}

/// A header line without the line end; `None` at the end of the stream.
fn header(source: &mut impl BufRead) -> Result<Option<String>, FrameError> {
    let mut line = Vec::new();
    let count = source.take(LONGEST_HEADER).read_until(b'\n', &mut line)?;
    Ok((count > 0).then(|| String::from_utf8_lossy(&line).trim_end().to_owned()))
}
