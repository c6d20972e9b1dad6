//! The region of the plane in which an object is, and the walls of the finger that bound it.

use crate::Wall;
use finray_model::finger::{Finger, Joints, Part as FingerPart, Plate};
use finray_model::mesh::Line;
use finray_model::{Mesh, Vector};

/// A region of the plane that the walls of a finger bound.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Region {
    /// Outside plates and base.
    Outside,
    /// Between two ribs, or between the base or the tip and a rib. Cells are numbered from 0 at the base.
    Cell(usize),
}

/// A member of the finger that bounds a region.
#[derive(Debug, Clone)]
pub(crate) struct Boundary {
    /// The wall to which the member belongs.
    pub wall: Wall,
    /// Index of the member in [`Mesh::lines`].
    pub line: usize,
    /// Position along the wall at which the member starts, mm.
    pub from_mm: f64,
    /// 1 if the region is to the left of the member, -1 if it is to the right.
    pub side: f64,
}

impl Region {
    /// The region of the undeformed finger that contains a point (mm, finger frame).
    pub(crate) fn of(finger: &Finger, point: Vector) -> Region {
        let at = |plate: Plate, level: usize| finger.plate_point(plate, finger.plate_positions_mm(plate)[level]);
        let holds = |cell: &usize| {
            let corners = [
                at(Plate::Back, *cell),
                at(Plate::Back, cell + 1),
                at(Plate::Front, cell + 1),
                at(Plate::Front, *cell),
            ];
            // The corners are counter-clockwise, and the cell is convex.
            (0..4).all(|i| (corners[(i + 1) % 4] - corners[i]).perp(&(point - corners[i])) >= 0.0)
        };
        (0..=finger.rib_count()).find(holds).map_or(Region::Outside, Region::Cell)
    }

    /// Whether the base bounds the region.
    pub(crate) fn meets_base(self) -> bool {
        matches!(self, Region::Outside | Region::Cell(0))
    }

    /// The members that bound the region: of the front plate, of the back plate, then ribs.
    pub(crate) fn boundaries(self, mesh: &Mesh) -> Vec<Boundary> {
        let finger = mesh.finger();
        let mut all = boundaries(mesh);
        all.retain(|boundary| match (self, boundary.wall) {
            (Region::Outside, Wall::Front | Wall::Back) => true,
            (Region::Cell(cell), Wall::Front | Wall::Back) => {
                boundary.from_mm == finger.plate_positions_mm(plate_of(boundary.wall))[cell]
                    && !mesh.lines()[boundary.line].members.is_empty()
            }
            (Region::Cell(cell), Wall::Rib(rib)) => rib == cell || rib + 1 == cell,
            _ => false,
        });
        for boundary in &mut all {
            // Plates run from base to tip, ribs from the back to the front plate.
            let is_left = match (self, boundary.wall) {
                (Region::Outside, wall) => wall == Wall::Front,
                (Region::Cell(cell), wall) => wall == Wall::Back || wall == Wall::Rib(cell),
            };
            boundary.side = if is_left { 1.0 } else { -1.0 };
        }
        all
    }
}

fn plate_of(wall: Wall) -> Plate {
    wall.plate().unwrap_or(Plate::Front)
}

/// All members of the finger: of the front plate and the back plate from base to tip, then ribs.
pub(crate) fn boundaries(mesh: &Mesh) -> Vec<Boundary> {
    let of = |part: FingerPart| mesh.lines().iter().enumerate().filter(move |(_, line)| line.part == part);
    let plate = |wall: Wall| {
        let positions_mm = mesh.finger().plate_positions_mm(plate_of(wall));
        of(plate_of(wall).into())
            .zip(positions_mm)
            .map(|((line, _), from_mm)| Boundary { wall, line, from_mm, side: 1.0 })
            .collect::<Vec<_>>()
    };
    let ribs = of(FingerPart::Ribs).enumerate();
    let ribs = ribs.map(|(rib, (line, _))| Boundary { wall: Wall::Rib(rib), line, from_mm: 0.0, side: 1.0 });
    plate(Wall::Front).into_iter().chain(plate(Wall::Back)).chain(ribs).collect()
}

impl Boundary {
    /// Whether contact with the member is modelled.
    pub(crate) fn is_modelled(&self, finger: &Finger) -> bool {
        let ribs = &finger.description().ribs;
        match self.wall.plate() {
            Some(plate) => !finger.tapers(plate),
            None => ribs.strip.is_some() && ribs.joints == Joints::Rigid && !finger.has_brackets(),
        }
    }

    /// Half the thickness of the member at a position along its wall, mm.
    pub(crate) fn half_mm(&self, finger: &Finger, s_mm: f64) -> f64 {
        let ribs = &finger.description().ribs;
        let of_rib = |rib: usize| {
            let each = ribs.thicknesses_mm.as_ref().map(|each_mm| each_mm[rib]);
            each.or(ribs.strip.map(|strip| strip.thickness_mm)).unwrap_or(0.0)
        };
        0.5 * match self.wall {
            Wall::Rib(rib) => of_rib(rib),
            wall => finger.thickness_mm(plate_of(wall), s_mm),
        }
    }

    /// Half the thickness of the member, mm, that an object may not overlap: for the back plate at most that of the front plate, because a thicker
    /// back plate reaches through the front plate's surface at the tip.
    pub(crate) fn overlapping_half_mm(&self, finger: &Finger, s_mm: f64) -> f64 {
        let own_mm = self.half_mm(finger, s_mm);
        if self.wall == Wall::Back { own_mm.min(0.5 * finger.thickness_mm(Plate::Front, 0.0)) } else { own_mm }
    }

    /// The member in the mesh.
    pub(crate) fn line<'m>(&self, mesh: &'m Mesh) -> &'m Line {
        &mesh.lines()[self.line]
    }
}
