//! Writes frames as YUV4MPEG2.

use super::chroma::Siting;
use super::{FrameLayout, Samples};
use image::RgbImage;
use std::io::{Error, ErrorKind, Write};

/// Largest denominator of a frame rate in a header. Decoders hold numerator and denominator in 32 bits.
const LARGEST_DENOMINATOR: u32 = 10_000;

/// Writes images as the frames of a YUV4MPEG2 stream, with 8 bits a sample, chroma for each pixel (C444) and the full range of values.
///
/// [`FrameReader`](super::FrameReader) restores each channel of each pixel within one grey level.
pub struct FrameWriter<W> {
    out: W,
    layout: FrameLayout,
    /// Samples of a frame: luma, blue chroma, red chroma.
    samples: Vec<u8>,
}

impl<W: Write> FrameWriter<W> {
    /// Begins a stream of frames of `size_px` (width and height, px), of which `per_second` arrive in a second. `None` for an unknown rate.
    ///
    /// # Errors
    /// [`std::io::Error`] if the header cannot be written.
    pub fn yuv4mpeg2(mut out: W, size_px: [u32; 2], per_second: Option<f64>) -> std::io::Result<FrameWriter<W>> {
        let layout =
            FrameLayout { size_px, per_second, samples: Samples::Yuv(Some([Siting::Each; 2])), is_full_range: true };
        let [width, height] = size_px;
        let rate = per_second.map_or("0:0".to_owned(), ratio);
        writeln!(out, "YUV4MPEG2 W{width} H{height} F{rate} Ip A1:1 C444 XCOLORRANGE=FULL")?;
        out.flush()?;
        Ok(FrameWriter { out, layout, samples: Vec::new() })
    }

    /// Writes a frame, and flushes the output.
    ///
    /// # Errors
    /// [`std::io::Error`] if the frame cannot be written, or if the size of the image differs from that of the stream.
    ///
    /// # Reference
    /// ITU-R BT.601: Y = 0.299 R + 0.587 G + 0.114 B, Cb = (B - Y) / 1.772, Cr = (R - Y) / 1.402.
    pub fn write(&mut self, image: &RgbImage) -> std::io::Result<()> {
        let (found, expected) = (<[u32; 2]>::from(image.dimensions()), self.layout.size_px);
        if found != expected {
            let message = format!("expected a frame of {expected:?} px, found {found:?}");
            return Err(Error::new(ErrorKind::InvalidInput, message));
        }
        self.samples.resize(self.layout.byte_count(), 0);
        let (luma, chroma) = self.samples.split_at_mut(self.layout.byte_count() / 3);
        let (blue, red) = chroma.split_at_mut(luma.len());
        for (((pixel, y), cb), cr) in image.pixels().zip(luma).zip(blue).zip(red) {
            [*y, *cb, *cr] = yuv(pixel.0);
        }
        self.out.write_all(b"FRAME\n")?;
        self.out.write_all(&self.samples)?;
        self.out.flush()
    }
}

/// Luma, blue chroma and red chroma of a pixel.
fn yuv(rgb: [u8; 3]) -> [u8; 3] {
    let [red, green, blue] = rgb.map(f32::from);
    let luma = 0.299 * red + 0.587 * green + 0.114 * blue;
    // A conversion from f32 to u8 limits the value to 0 to 255.
    [luma, 128.0 + (blue - luma) / 1.772, 128.0 + (red - luma) / 1.402].map(|value| (value + 0.5) as u8)
}

/// A frame rate as `numerator:denominator`; the denominator is the smallest power of ten that makes the numerator whole, up to `LARGEST_DENOMINATOR`.
fn ratio(per_second: f64) -> String {
    let mut denominator = 1;
    while denominator < LARGEST_DENOMINATOR && (per_second * f64::from(denominator)).fract() != 0.0 {
        denominator *= 10;
    }
    format!("{:.0}:{denominator}", (per_second * f64::from(denominator)).round())
}
