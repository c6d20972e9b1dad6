//! Image files: PNG and JPEG, by their content.

use super::{FileError, read_bytes};
use image::{ImageError, ImageFormat, ImageReader, Limits, RgbImage};
use std::io::Cursor;
use std::path::Path;

/// Largest side of an image, px, and most memory that decoding may take, bytes.
const LARGEST_SIDE_PX: u32 = 20_000;
const MOST_MEMORY: u64 = 1 << 30;

/// Reads an image as red, green and blue of 8 bits: grey becomes three equal channels, 16 bits are rounded, and what is transparent is
/// taken for opaque. `-` is standard input.
///
/// # Errors
/// [`FileError`] for what is no PNG or JPEG file, is damaged, or is larger than 20 000 px a side.
pub fn load_image(path: &Path) -> Result<RgbImage, FileError> {
    let bytes = read_bytes(path)?;
    let wrong = |message: String| FileError::content(path, message);
    let format = image::guess_format(&bytes)
        .ok()
        .filter(|format| matches!(format, ImageFormat::Png | ImageFormat::Jpeg))
        .ok_or_else(|| wrong("expected an image, PNG or JPEG".to_owned()))?;
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    let mut limits = Limits::default();
    (limits.max_image_width, limits.max_image_height) = (Some(LARGEST_SIDE_PX), Some(LARGEST_SIDE_PX));
    limits.max_alloc = Some(MOST_MEMORY);
    reader.limits(limits);
    let image = reader.decode().map_err(|error| match error {
        ImageError::Limits(_) => wrong(format!("expected an image of at most {LARGEST_SIDE_PX} px a side")),
        _ => wrong("expected a whole image; this one is damaged or cut off".to_owned()),
    })?;
    Ok(image.into_rgb8())
}

/// The name of an image's file, without its folder: what tables call the image.
pub fn image_name(path: &Path) -> String {
    path.file_name().map_or_else(|| path.display().to_string(), |name| name.to_string_lossy().into_owned())
}

/// An image as the bytes of a PNG file.
///
/// # Errors
/// None in memory; the signature is the encoder's.
pub fn to_png(image: &RgbImage) -> Result<Vec<u8>, ImageError> {
    let mut bytes = Vec::new();
    image.write_to(&mut Cursor::new(&mut bytes), ImageFormat::Png)?;
    Ok(bytes)
}
