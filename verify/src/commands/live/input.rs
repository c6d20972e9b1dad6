//! Frames of a stream or of image files.

use crate::commands::prelude::*;
use finray_files::frames::{FrameError, FrameLayout, FrameReader};
use finray_files::positions::PositionReader;
use finray_model::observation::Observation;
use image::RgbImage;
use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::time::Instant;

/// Bytes that are read from a stream at once.
const AT_ONCE: usize = 1 << 20;
/// First bytes of a stream of frames.
const MAGIC: &[u8] = b"YUV4MPEG2";

/// What a frame holds.
pub enum Content {
    /// An image.
    Pixels(RgbImage),
    /// Positions of markers.
    Markers(Observation),
    /// Reason why the frame cannot be read.
    Unreadable(String),
}

/// A frame of a stream.
pub struct Frame {
    /// Number of the frame in the stream, from 0.
    pub number: usize,
    /// Time of the frame in its stream, s, if it is known.
    pub time_s: Option<f64>,
    /// Time at which the frame had arrived completely.
    pub arrived: Instant,
    /// Number of frames since the last evaluated one that were dropped.
    pub dropped: usize,
    /// Image or positions.
    pub content: Content,
}

type Stream = Box<dyn BufRead + Send>;

/// Source of frames.
pub enum Source {
    /// A stream of images.
    Images(FrameReader<Stream>),
    /// A stream of positions.
    Positions(PositionReader<Stream>),
    /// Image files, the next one last.
    Files(Vec<PathBuf>),
}

impl Source {
    /// A stream from a file, or from standard input for `-`. `size_px` is the size of raw frames; without it, the first bytes decide the format.
    ///
    /// # Errors
    /// [`Failure`] if the stream cannot be read or its format is unknown.
    pub fn open(path: &Path, size_px: Option<[u32; 2]>) -> Result<Source, Failure> {
        let source: Box<dyn Read + Send> = match is_standard_stream(path) {
            true => Box::new(std::io::stdin()),
            false => {
                Box::new(File::open(path).map_err(|reason| FileError::Unreadable { path: path.to_owned(), reason })?)
            }
        };
        let mut source: Stream = Box::new(BufReader::with_capacity(AT_ONCE, source));
        let wrong = |reason: &dyn ToString| Failure::from(FileError::content(path, reason.to_string()));
        if let Some(size_px) = size_px {
            return Ok(Source::Images(FrameReader::raw(source, FrameLayout::rgb(size_px))));
        }
        let begin = source.fill_buf().map_err(|reason| FileError::Unreadable { path: path.to_owned(), reason })?;
        match begin {
            [] => Err(wrong(&"expected a stream, found nothing")),
            _ if begin.starts_with(MAGIC) => {
                FrameReader::yuv4mpeg2(source).map(Source::Images).map_err(|error| wrong(&error))
            }
            _ if begin.is_ascii() || begin.starts_with(b"\xef\xbb\xbf") => {
                PositionReader::new(source).map(Source::Positions).map_err(|error| wrong(&error))
            }
            _ => Err(wrong(&"expected YUV4MPEG2, JSON lines or CSV; raw frames need --format and --size")),
        }
    }

    /// Image files, in this order.
    pub fn of_images(images: &[PathBuf]) -> Source {
        Source::Files(images.iter().rev().cloned().collect())
    }

    /// The next frame, with the dropped frame `spare` for reuse of its memory. `None` at the end.
    ///
    /// # Errors
    /// [`Failure`] if the stream cannot be read on.
    pub fn next(&mut self, number: usize, bytes: &mut Vec<u8>, spare: Option<Frame>) -> Result<Option<Frame>, Failure> {
        let frame = |time_s, arrived, content| Some(Frame { number, time_s, arrived, dropped: 0, content });
        Ok(match self {
            Source::Images(reader) => {
                let layout = reader.layout();
                match reader.read(bytes) {
                    Ok(true) => {}
                    Ok(false) => return Ok(None),
                    Err(error @ FrameError::CutOff { .. }) => {
                        print_message(format_args!("warning: {error}; the stream ends here"));
                        return Ok(None);
                    }
                    Err(error) => return Err(bad_input(error)),
                }
                let arrived = Instant::now();
                let [width, height] = layout.size_px;
                let mut image = match spare.map(|frame| frame.content) {
                    Some(Content::Pixels(image)) => image,
                    _ => RgbImage::new(width, height),
                };
                layout.to_rgb(bytes, &mut image);
                frame(layout.per_second.map(|rate| number as f64 / rate), arrived, Content::Pixels(image))
            }
            Source::Positions(reader) => match reader.next() {
                None => None,
                Some(Ok((seen, t_s))) => frame(t_s, Instant::now(), Content::Markers(seen)),
                Some(Err(reason)) => frame(None, Instant::now(), Content::Unreadable(reason)),
            },
            Source::Files(paths) => match paths.pop() {
                None => None,
                Some(path) => {
                    let content = match load_image(&path) {
                        Ok((image, _)) => Content::Pixels(image),
                        Err(error) => Content::Unreadable(error.to_string()),
                    };
                    frame(None, Instant::now(), content)
                }
            },
        })
    }
}
