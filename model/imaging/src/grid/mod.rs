//! A plane grid in an image, found without a guess: dots or holes, or the corners of a chessboard, and which are neighbours.
//!
//! Dots may be dark or light, unevenly lit, and partly hidden; the grid may be seen at a slant and through a lens that bends it.

mod corners;
mod dots;
mod lattice;
mod lens;
mod patches;
mod ring;

pub use lens::{LensOfGridsError, lens_of_grids};

use finray_model::Vector;
use finray_model::camera::Pixel;
use image::{GrayImage, RgbImage};
use lattice::Lattice;
use patches::{Dot, Patches, patches};

/// Dots that a grid must have.
const LEAST_DOTS: usize = 12;
/// Half the side of the blocks over which brightness is averaged for the threshold, px: a dot and its surroundings, for small and large ones.
const BLOCKS_PX: [u32; 4] = [10, 25, 60, 120];

/// Fewest dots of an outline along the diagonals, and how many of them there must be for one of an outline along rows and columns: a rectangle
/// has four at its corners.
const LEAST_DIAGONAL: usize = 3;
const DIAGONAL: usize = 2;

/// What a grid is made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GridKind {
    /// Dots or holes in rows and columns, a pitch apart.
    Dots,
    /// Dots or holes in rows a pitch apart, every other row displaced by a pitch, dots of a row two pitches apart: neighbours are diagonal.
    AsymmetricDots,
    /// The inner corners of a chessboard; the pitch is the side of a square.
    Chessboard,
}

impl GridKind {
    /// Its name, with an article.
    pub fn name(self) -> &'static str {
        match self {
            GridKind::Dots => "a grid",
            GridKind::AsymmetricDots => "an asymmetric grid",
            GridKind::Chessboard => "a chessboard",
        }
    }

    /// Where a dot is, in pitches.
    fn position(self, [column, row]: [i32; 2]) -> Vector {
        let [column, row] = [column, row].map(f64::from);
        match self {
            GridKind::Dots | GridKind::Chessboard => Vector::new(column, row),
            GridKind::AsymmetricDots => Vector::new(column + row, column - row),
        }
    }
}

/// The grid of an image.
#[derive(Debug, Clone, PartialEq)]
pub struct Grid {
    /// Its dots, or the corners of its squares.
    pub dots: Vec<GridDot>,
    is_chessboard: bool,
    /// Dots where it ends along its rows and columns, and along its diagonals.
    outline: [usize; 2],
}

impl Grid {
    /// What grids of one board are made of; `None` if some are chessboards and some are not. Where a grid of dots ends tells whether it is asymmetric:
    /// one image may not show that, so all are asked.
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

/// A dot of a grid, or a corner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GridDot {
    /// Column and row, counted from some dot along the directions in which neighbours are nearest.
    pub index: [i32; 2],
    /// The middle of its light.
    pub pixel: Pixel,
    /// Radius of a disc of its area, px; 0 for a corner.
    pub radius_px: f64,
}

/// No grid is seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error(
    "expected a plane grid of round dots or holes, or a chessboard, at least {LEAST_DOTS} dots or corners of which are neighbours; found {found}"
)]
pub struct NoGrid {
    /// Dots or corners of the largest lattice.
    pub found: usize,
}

/// Finds the grid: of all ways to tell dots from their surroundings, the one with the largest lattice. The squares of a chessboard are such dots as
/// well, unless they are large or cut by the border: then, and where no dots are found, its corners are sought.
///
/// # Errors
/// [`NoGrid`] for an image without one.
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
