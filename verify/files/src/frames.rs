//! Frames of a video stream: YUV4MPEG2, or raw RGB.

mod writer;

pub use writer::FrameWriter;

use image::RgbImage;
use std::io::{BufRead, Read};

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
    /// A plane of luma, and two planes of chroma. These numbers are the ratios of the image's width and height to the width and height of a chroma
    /// plane. `None` for luma without chroma.
    Yuv(Option<[usize; 2]>),
}

/// Size, arrangement and rate of the frames of a stream.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrameLayout {
    /// Width and height, px.
    pub size_px: [u32; 2],
    /// Frames per second, if the stream states it.
    pub per_second: Option<f64>,
    samples: Samples,
    /// Whether luma and chroma use all values from 0 to 255. Otherwise luma ranges from 16 to 235 and chroma from 16 to 240 (ITU-R BT.601).
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
            samples: Samples::Yuv(Some([2, 2])),
            is_full_range: false,
        };
        for field in fields {
            let (key, value) = field.split_at_checked(1).unwrap_or((field, ""));
            match key {
                "W" => layout.size_px[0] = value.parse().unwrap_or(0),
                "H" => layout.size_px[1] = value.parse().unwrap_or(0),
                "F" => layout.per_second = rate(value),
                "C" => layout.samples = samples(value)?,
                "X" if value == "COLORRANGE=FULL" => layout.is_full_range = true,
                "I" if !matches!(value, "p" | "?") => {
                    return Err(FrameError::Header(format!("expected progressive frames (Ip), found I{value}")));
                }
                _ => {}
            }
        }
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
            Samples::Yuv(Some([across, down])) => width * height + 2 * width.div_ceil(across) * height.div_ceil(down),
        }
    }

    /// Converts the bytes of a frame to an image of the same size. Chroma samples that several pixels share are repeated for each of these pixels.
    ///
    /// # Reference
    /// ITU-R BT.601: R = Y + 1.402 Cr, G = Y - 0.344136 Cb - 0.714136 Cr, B = Y + 1.772 Cb.
    pub fn to_rgb(&self, bytes: &[u8], image: &mut RgbImage) {
        let [width, height] = self.size_px.map(|px| px as usize);
        let Samples::Yuv(chroma) = self.samples else {
            return image.copy_from_slice(bytes);
        };
        let (luma, rest) = bytes.split_at(width * height);
        // Gain of luma (in 1/65536), value of luma for black, and gains of chroma (in 1/65536).
        let (gain, black, of_chroma) = if self.is_full_range {
            (65536, 0, [91881, -22554, -46802, 116130])
        } else {
            (76309, 16, [104597, -25675, -53279, 132201])
        };
        let byte = |value: i32| ((value + 32768) >> 16).clamp(0, 255) as u8;
        for (row, (line, luma)) in image.chunks_exact_mut(3 * width).zip(luma.chunks_exact(width)).enumerate() {
            let Some([across, down]) = chroma else {
                for (pixel, y) in line.chunks_exact_mut(3).zip(luma) {
                    pixel.fill(byte(gain * (i32::from(*y) - black)));
                }
                continue;
            };
            let (columns, rows) = (width.div_ceil(across), height.div_ceil(down));
            let (blue, red) = rest.split_at(columns * rows);
            let of_row = row / down * columns..(row / down + 1) * columns;
            let (blue, red) = (&blue[of_row.clone()], &red[of_row]);
            let set = |pixel: &mut [u8], y: u8, cb: u8, cr: u8| {
                let y = gain * (i32::from(y) - black);
                let (cb, cr) = (i32::from(cb) - 128, i32::from(cr) - 128);
                pixel[0] = byte(y + of_chroma[0] * cr);
                pixel[1] = byte(y + of_chroma[1] * cb + of_chroma[2] * cr);
                pixel[2] = byte(y + of_chroma[3] * cb);
            };
            match across {
                1 => line
                    .chunks_exact_mut(3)
                    .zip(luma)
                    .zip(blue)
                    .zip(red)
                    .for_each(|(((p, y), cb), cr)| set(p, *y, *cb, *cr)),
                _ => line
                    .chunks_exact_mut(3)
                    .zip(luma)
                    .enumerate()
                    .for_each(|(i, (p, y))| set(p, *y, blue[i / across], red[i / across])),
            }
        }
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
        "420" | "420jpeg" | "420mpeg2" | "420paldv" => Ok(Samples::Yuv(Some([2, 2]))),
        "422" => Ok(Samples::Yuv(Some([2, 1]))),
        "444" => Ok(Samples::Yuv(Some([1, 1]))),
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

    /// Reads the next frame into `bytes`. Returns false at the end of the stream.
    ///
    /// # Errors
    /// [`FrameError`] if the stream cannot be read, ends within the frame, or continues with something else.
    pub fn read(&mut self, bytes: &mut Vec<u8>) -> Result<bool, FrameError> {
        let (frame, expected) = (self.frame, self.layout.byte_count());
        if self.has_headers {
            let Some(line) = header(&mut self.source)? else { return Ok(false) };
            match line.split_ascii_whitespace().next() {
                Some("FRAME") => {}
                _ if "FRAME".starts_with(&line) && self.source.fill_buf()?.is_empty() => {
                    return Err(FrameError::CutOff { frame, found: 0, expected });
                }
                _ => return Err(FrameError::NotAFrame { frame, found: line.chars().take(40).collect() }),
            }
        }
        bytes.clear();
        let found = (&mut self.source).take(expected as u64).read_to_end(bytes)?;
        match found {
            0 if !self.has_headers => Ok(false),
            _ if found < expected => Err(FrameError::CutOff { frame, found, expected }),
            _ => {
                self.frame += 1;
                Ok(true)
            }
        }
    }
}

/// A header line without the line end; `None` at the end of the stream.
fn header(source: &mut impl BufRead) -> Result<Option<String>, FrameError> {
    let mut line = Vec::new();
    let count = source.take(LONGEST_HEADER).read_until(b'\n', &mut line)?;
    Ok((count > 0).then(|| String::from_utf8_lossy(&line).trim_end().to_owned()))
}
