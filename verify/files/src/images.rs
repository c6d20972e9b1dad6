//! Reads PNG and JPEG images, recognised by their content, and names images in tables.

use super::{FileError, read_bytes};
use image::metadata::Orientation;
use image::{ImageDecoder, ImageError, ImageFormat, ImageReader, Limits, RgbImage};
use std::collections::HashMap;
use std::io::Cursor;
use std::path::{Component, Path, PathBuf};

/// An image is refused if its width or height exceeds this limit, px, or if decoding needs more memory than `MOST_MEMORY`, bytes.
const LARGEST_SIDE_PX: u32 = 20_000;
const MOST_MEMORY: u64 = 1 << 30;

/// Reads an image as 8-bit red, green and blue. Grey becomes three equal channels, 16 bits are rounded to 8, and transparency is ignored. The image is rotated
/// or mirrored according to its EXIF orientation, as image viewers do. The orientation is also returned. `-` is standard input.
///
/// # Errors
/// [`FileError`] if the file is not PNG or JPEG, is damaged, or is wider or higher than 20 000 px.
pub fn load_image(path: &Path) -> Result<(RgbImage, Orientation), FileError> {
    let bytes = read_bytes(path)?;
    let wrong = |message: String| FileError::content(path, message);
    let format = image::guess_format(&bytes)
        .ok()
        .filter(|format| matches!(format, ImageFormat::Png | ImageFormat::Jpeg))
        .ok_or_else(|| wrong("expected an image, PNG or JPEG".to_owned()))?;
    let mut reader = ImageReader::with_format(Cursor::new(&bytes), format);
    let mut limits = Limits::default();
    (limits.max_image_width, limits.max_image_height) = (Some(LARGEST_SIDE_PX), Some(LARGEST_SIDE_PX));
    limits.max_alloc = Some(MOST_MEMORY);
    reader.limits(limits);
    let mut image = reader.decode().map_err(|error| match error {
        ImageError::Limits(_) => {
            wrong(format!("expected an image of at most {LARGEST_SIDE_PX} px in width and height"))
        }
        _ => wrong("expected a whole image; this one is damaged or cut off".to_owned()),
    })?;
    let orientation = orientation(&bytes, format);
    image.apply_orientation(orientation);
    Ok((image.into_rgb8(), orientation))
}

/// The EXIF orientation of an image file; "no rotation" if none can be read.
fn orientation(bytes: &[u8], format: ImageFormat) -> Orientation {
    let of_head = || ImageReader::with_format(Cursor::new(bytes), format).into_decoder().ok()?.orientation().ok();
    match of_head() {
        Some(Orientation::NoTransforms) | None if format == ImageFormat::Png => {
            after_pixels(bytes).unwrap_or(Orientation::NoTransforms)
        }
        found => found.unwrap_or(Orientation::NoTransforms),
    }
}

/// The orientation in the eXIf chunk of a PNG file. The chunk may follow the pixels, where the decoder does not search.
fn after_pixels(png: &[u8]) -> Option<Orientation> {
    const SIGNATURE: usize = 8;
    // Bytes of a chunk besides its data: length (4), name (4) and checksum (4).
    const AROUND: usize = 12;
    let mut rest = png.get(SIGNATURE..)?;
    loop {
        let (head, data) = rest.split_first_chunk::<8>()?;
        let length = u32::from_be_bytes([head[0], head[1], head[2], head[3]]) as usize;
        if &head[4..] == b"eXIf" {
            return Orientation::from_exif_chunk(data.get(..length)?);
        }
        rest = rest.get(AROUND.checked_add(length)?..)?;
    }
}

/// Names of images in a table. An image is named by its file name, preceded by the folders that distinguish the image from the others, joined by `/`.
///
/// # Errors
/// [`FileError`] if an image is given twice.
pub fn image_names(paths: &[PathBuf]) -> Result<Vec<String>, FileError> {
    let parts: Vec<Vec<String>> = paths.iter().map(|path| parts_of(path)).collect();
    let mut names: Vec<Option<String>> = vec![None; paths.len()];
    for length in 1..=parts.iter().map(Vec::len).max().unwrap_or(0) {
        let ends: Vec<String> =
            parts.iter().map(|parts| parts[parts.len().saturating_sub(length)..].join("/")).collect();
        let mut counts: HashMap<&str, usize> = HashMap::new();
        ends.iter().for_each(|end| *counts.entry(end).or_default() += 1);
        for (name, end) in names.iter_mut().zip(&ends).filter(|(name, end)| name.is_none() && counts[end.as_str()] == 1)
        {
            *name = Some(end.clone());
        }
    }
    let twice = |path| FileError::content(path, "the image is given twice");
    names.into_iter().zip(paths).map(|(name, path)| name.ok_or_else(|| twice(path))).collect()
}

/// The folders of a file from the root, then its name; `..` removes the folder before it.
fn parts_of(path: &Path) -> Vec<String> {
    let whole = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    whole.components().fold(Vec::new(), |mut parts, part| {
        match part {
            Component::Normal(name) => parts.push(name.to_string_lossy().into_owned()),
            Component::ParentDir => parts.truncate(parts.len().saturating_sub(1)),
            Component::CurDir | Component::RootDir | Component::Prefix(_) => {}
        }
        parts
    })
}

/// Finds an image of a table by name or path. The first match counts, in this order: an image with exactly this name, the longest name with which the
/// path ends, or the only name that ends with the path.
///
/// # Errors
/// A message if no image matches, or if more than one matches.
pub fn image_named<'n>(wanted: &str, names: &[&'n str]) -> Result<&'n str, String> {
    let path: PathBuf = Path::new(wanted).components().filter(|part| *part != Component::CurDir).collect();
    let given = names.iter().copied().filter(|name| !name.is_empty() && path.ends_with(name));
    if let Some(name) = names.iter().copied().find(|name| *name == wanted).or(given.max_by_key(|name| name.len())) {
        return Ok(name);
    }
    let ends = |name: &&str| !wanted.is_empty() && Path::new(name).ends_with(&path);
    match names.iter().copied().filter(ends).collect::<Vec<_>>()[..] {
        [name] => Ok(name),
        [] => Err(format!("image {wanted:?} is not among the located images")),
        [one, other, ..] => Err(format!("image {wanted:?} may be {one} or {other}: give more of its path")),
    }
}
