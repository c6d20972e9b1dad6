//! Detection of a plane grid in an image without an initial guess: finds dots, holes or chessboard corners, and their columns and rows.
//!
//! Dots may be dark or light, unevenly lit and partly hidden. The grid may be slanted, and the lens may distort the image.

mod corners;
mod dots;
mod lattice;
mod lens;
mod patches;
mod ring;

pub use lens::{LensOfGridsError, lens_of_grids, poses_of_grids};

use finray_model::Vector;
use finray_model::camera::Pixel;
use image::{GrayImage, RgbImage};
use lattice::Lattice;
use patches::{Dot, Patches, patches};

/// A grid needs at least this number of dots.
const LEAST_DOTS: usize = 12;
/// Half the side of the blocks over which brightness is averaged for the threshold, px. The sizes suit small to large dots.
const BLOCKS_PX: [u32; 4] = [10, 25, 60, 120];

/// A grid counts as asymmetric only if at least this number of dots on the outlines lies along diagonals.
const LEAST_DIAGONAL: usize = 3;
/// A grid counts as asymmetric only if the outline dots along diagonals are more than this many times as numerous as those along rows and columns. A
/// rectangular grid already has four diagonal dots, at its corners.
const DIAGONAL: usize = 2;

/// Type of a grid.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GridKind {
    /// Dots or holes in rows and columns. The pitch is the distance between neighbours.
    Dots,
    /// Dots or holes in rows that are one pitch apart. The dots of a row are two pitches apart, and every other row is displaced by one pitch, so the
    /// nearest neighbours of a dot lie diagonally.
    AsymmetricDots,
    /// The inner corners of a chessboard. The pitch is the side of a square.
    Chessboard,
}

impl GridKind {
    /// Name of the type with its article, for messages.
    pub fn name(self) -> &'static str {
        match self {
            GridKind::Dots => "a grid",
            GridKind::AsymmetricDots => "an asymmetric grid",
            GridKind::Chessboard => "a chessboard",
        }
    }

    /// Position of the dot at a column and row, in pitches.
    fn position(self, [column, row]: [i32; 2]) -> Vector {
        let [column, row] = [column, row].map(f64::from);
        match self {
            GridKind::Dots | GridKind::Chessboard => Vector::new(column, row),
            GridKind::AsymmetricDots => Vector::new(column + row, column - row),
        }
    }
}

/// A grid that was found in an image.
#[derive(Debug, Clone, PartialEq)]
pub struct Grid {
    /// The dots of the grid, or the inner corners of the chessboard.
    pub dots: Vec<GridDot>,
    /// Whether the grid consists of the corners of a chessboard.
    is_chessboard: bool,
    /// Number of outline dots along rows and columns, and number of outline dots along diagonals.
    outline: [usize; 2],
}

impl Grid {
    /// Common type of grids that show the same board. `None` if some grids are chessboards and others are not. A single image may not show whether
    /// dots are asymmetric, so the outlines of all grids decide together.
    pub fn common_kind(grids: &[Grid]) -> Option<GridKind> {
        let boards = grids.iter().filter(|grid| grid.is_chessboard).count();
        let [straight, diagonal] = [0, 1].map(|way| grids.iter().map(|grid| grid.outline[way]).sum::<usize>());
        match boards {
            0 if diagonal >= LEAST_DIAGONAL && diagonal > DIAGONAL * straight => Some(GridKind::AsymmetricDots),
            0 => Some(GridKind::Dots),
            _ => (boards == grids.len()).then_some(GridKind::Chessboard),
        }
    }

    fn large_enough(self, others: usize) -> Result<Grid, NoGrid> {
        if self.dots.len() < LEAST_DOTS { Err(NoGrid { found: self.dots.len().max(others) }) } else { Ok(self) }
    }
}

/// A dot of a grid, or a corner of a chessboard.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GridDot {
    /// Column and row along the directions of the nearest neighbours, counted from an arbitrary dot.
    pub index: [i32; 2],
    /// Centre of the dot's light, px.
    pub pixel: Pixel,
    /// Radius of a disc with the dot's area, px; 0 for a corner.
    pub radius_px: f64,
}

/// Error for an image that shows no grid.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error(
    "expected a plane grid of round dots or holes, or a chessboard, with at least {LEAST_DOTS} neighbouring dots or corners; found {found}"
)]
pub struct NoGrid {
    /// Number of dots or corners in the largest lattice that was found.
    pub found: usize,
}

/// Finds the grid with the most dots, trying several thresholds. The squares of a chessboard may also count as dots, unless they are large or cut by
/// the border. Chessboard corners are therefore searched for if the dots are squares, or if there are too few dots.
///
/// # Errors
/// [`NoGrid`] if the image shows no grid of at least 12 dots or corners.
pub fn find_grid(image: &RgbImage) -> Result<Grid, NoGrid> {
    let grey: GrayImage = image::imageops::grayscale(image);
    let (mut seen, mut lattice) = (Patches::default(), Lattice::new());
    for block_px in BLOCKS_PX {
        for are_dark in [true, false] {
            let patches = patches(&grey, block_px, are_dark);
            let found = lattice::largest(&patches.dots, lattice::seeds(&patches.dots));
            if found.len() > lattice.len() {
                (seen, lattice) = (patches, found);
            }
        }
    }
    let too_few = if lattice.len() < LEAST_DOTS { lattice.len() } else { 0 };
    if too_few == lattice.len() || corners::are_squares(&grey, &seen.dots, &lattice) {
        let corner = |(index, pixel)| GridDot { index, pixel, radius_px: 0.0 };
        let dots: Vec<GridDot> = corners::board(&grey).into_iter().map(corner).collect();
        return Grid { dots, is_chessboard: true, outline: [0; 2] }.large_enough(too_few);
    }
    let outline = lattice::outline(&seen.dots, &lattice, [grey.width(), grey.height()]);
    let all: Vec<Dot> = seen.dots.iter().chain(&seen.others).copied().collect();
    let measured = |(&index, &number): (&[i32; 2], &usize)| {
        let (pixel, radius_px) = dots::measured(&grey, &seen.dots[number], &all)?;
        Some(GridDot { index, pixel, radius_px })
    };
    let mut dots: Vec<GridDot> = lattice.iter().filter_map(measured).collect();
    dots.sort_by_key(|dot| dot.index);
    Grid { dots, is_chessboard: false, outline }.large_enough(0)
}
