//! Parts of a finger's surface, which meet the features of an object.

use crate::TouchedPart;
use crate::carrier::Carrier;

/// A part of a finger's surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Part {
    /// Line that carries the part.
    pub carrier: Carrier,
    /// Start and end of a piece on the line; equal for a disc.
    pub xi: [f64; 2],
    /// Radius of a disc, or half the thickness of the plate, mm.
    pub radius_mm: f64,
    /// 1 if the surface is to the left of the line, -1 if it is to the right.
    pub side: f64,
    /// Features of the object that the part can touch.
    pub touches: Touches,
    /// Rod, or position along the plate at which the part begins; reported to callers.
    pub touched: TouchedPart,
    /// Length of a piece along the plate, mm; 0 for a disc.
    pub length_mm: f64,
}

/// Features of an object that a part of a finger can touch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Touches {
    /// Corners and discs: a piece of the plate.
    Corners,
    /// Sides: a point between two pieces.
    Sides,
    /// Corners, discs and sides: a rod, or an end of the plate.
    All,
}
