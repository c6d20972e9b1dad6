//! Images from NumPy arrays, without a copy.

use crate::arrays::{found, is_masked};
use crate::error::failed;
use finray_imaging::{RgbRows, RgbView};
use image::RgbImage;
use numpy::{PyReadonlyArray2, PyReadonlyArray3, PyUntypedArrayMethods};
use pyo3::prelude::*;
use std::ops::Range;

/// The array of an image argument.
pub enum ImageArgument<'py> {
    /// Pixels (red, green, blue) of a colour image.
    Colour(PyReadonlyArray3<'py, u8>),
    /// Levels of a grey image.
    Grey(PyReadonlyArray2<'py, u8>),
}

/// The pixels of an image argument, borrowed from its array.
pub enum ImageView<'a> {
    /// Pixels (red, green, blue) of a colour image.
    Colour(RgbView<'a>),
    /// Levels of a grey image, row by row, and its width and height, px.
    Grey(&'a [u8], [u32; 2]),
}

impl<'py> ImageArgument<'py> {
    /// Reads an argument: a C-contiguous uint8 array of shape (height, width, 3), or of shape (height, width) for a grey image.
    pub fn of(value: &Bound<'py, PyAny>) -> PyResult<ImageArgument<'py>> {
        let expected = || {
            failed(format!(
                "expected an image: a uint8 array of shape (height, width, 3), in the order red, green, blue, or of shape (height, width), found {}",
                found(value)
            ))
        };
        let image = match value.extract::<PyReadonlyArray3<'py, u8>>() {
            Ok(colour) if colour.shape()[2] == 3 => ImageArgument::Colour(colour),
            Ok(_) => return Err(expected()),
            Err(_) => ImageArgument::Grey(value.extract().map_err(|_| expected())?),
        };
        if is_masked(value)? {
            return Err(failed("expected an image without a mask, found a masked array"));
        }
        let is_contiguous = match &image {
            ImageArgument::Colour(colour) => colour.is_c_contiguous(),
            ImageArgument::Grey(grey) => grey.is_c_contiguous(),
        };
        // `as_slice` would also accept an array in Fortran (column-major) order.
        if !is_contiguous {
            return Err(failed(
                "expected an image whose array is C-contiguous: numpy.ascontiguousarray copies an array into this form",
            ));
        }
        Ok(image)
    }

    /// The pixels, without a copy.
    pub fn view(&self) -> PyResult<ImageView<'_>> {
        let (shape, pixels) = match self {
            ImageArgument::Colour(array) => (array.shape(), array.as_slice()),
            ImageArgument::Grey(array) => (array.shape(), array.as_slice()),
        };
        let (height, width, pixels) = (shape[0], shape[1], pixels.map_err(failed)?);
        let side = |px: usize| u32::try_from(px).ok();
        let view = side(width).zip(side(height)).and_then(|(width, height)| match self {
            ImageArgument::Colour(_) => RgbView::from_raw(width, height, pixels).map(ImageView::Colour),
            ImageArgument::Grey(_) => Some(ImageView::Grey(pixels, [width, height])),
        });
        view.ok_or_else(|| failed(format!("expected an image of fewer pixels, found {width} x {height} px")))
    }
}

impl RgbRows for ImageView<'_> {
    fn size_px(&self) -> [u32; 2] {
        match self {
            ImageView::Colour(image) => image.size_px(),
            ImageView::Grey(_, size_px) => *size_px,
        }
    }

    fn row<'p>(&'p self, row: usize, columns: Range<usize>, buffer: &'p mut Vec<u8>) -> &'p [u8] {
        match self {
            ImageView::Colour(image) => image.row(row, columns, buffer),
            ImageView::Grey(levels, [width, _]) => {
                let start = row * *width as usize;
                buffer.clear();
                buffer.extend(levels[start + columns.start..start + columns.end].iter().flat_map(|level| [*level; 3]));
                buffer
            }
        }
    }
}

impl ImageView<'_> {
    /// A copy of the image.
    pub fn to_image(&self) -> RgbImage {
        let [width, height] = self.size_px();
        let (mut pixels, mut buffer) = (Vec::new(), Vec::new());
        for row in 0..height as usize {
            pixels.extend_from_slice(self.row(row, 0..width as usize, &mut buffer));
        }
        RgbImage::from_raw(width, height, pixels).unwrap_or_default()
    }
}
