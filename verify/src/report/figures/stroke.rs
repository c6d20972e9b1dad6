//! Lines cut to pieces: into dashes, and at the edge of the plotting area.

use super::frame::Point;

/// How a line is broken, so that lines differ by more than colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Dash {
    /// Unbroken.
    #[default]
    Solid,
    /// Long dashes.
    Dashed,
    /// Short dots.
    Dotted,
    /// Dashes and dots by turns.
    DashDotted,
}

impl Dash {
    /// Lengths drawn and left out by turns, in pixels.
    fn lengths(self) -> &'static [f64] {
        match self {
            Self::Solid => &[],
            Self::Dashed => &[9.0, 5.0],
            Self::Dotted => &[3.0, 4.0],
            Self::DashDotted => &[10.0, 4.0, 3.0, 4.0],
        }
    }
}

/// The drawn pieces of a line.
pub(super) fn dashes(line: &[Point], dash: Dash) -> Vec<Vec<Point>> {
    let lengths = dash.lengths();
    if lengths.is_empty() || line.is_empty() {
        return vec![line.to_vec()];
    }
    let mut pieces = vec![vec![line[0]]];
    let (mut phase, mut left) = (0, lengths[0]);
    for pair in line.windows(2) {
        let (mut from, to) = (pair[0], pair[1]);
        loop {
            let rest = distance(from, to);
            if rest <= left {
                left -= rest;
                if phase % 2 == 0 {
                    extend(&mut pieces, to);
                }
                break;
            }
            from = between(from, to, left / rest);
            if phase % 2 == 0 {
                extend(&mut pieces, from);
            } else {
                pieces.push(vec![from]);
            }
            phase = (phase + 1) % lengths.len();
            left = lengths[phase];
        }
    }
    pieces.retain(|piece| piece.len() > 1);
    pieces
}

fn extend(pieces: &mut [Vec<Point>], to: Point) {
    if let Some(piece) = pieces.last_mut() {
        piece.push(to);
    }
}

/// An upright rectangle in pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Area {
    pub(super) left: f64,
    pub(super) top: f64,
    pub(super) right: f64,
    pub(super) bottom: f64,
}

impl Area {
    /// A rectangle of this size about a centre.
    pub(super) fn about([x, y]: Point, width: f64, height: f64) -> Self {
        Self { left: x - width / 2.0, top: y - height / 2.0, right: x + width / 2.0, bottom: y + height / 2.0 }
    }

    /// The closed line around it.
    pub(super) fn outline(&self) -> [Point; 5] {
        let Self { left, top, right, bottom } = *self;
        [[left, top], [right, top], [right, bottom], [left, bottom], [left, top]]
    }

    /// Whether a point lies inside or on the edge.
    pub(super) fn holds(&self, [x, y]: Point) -> bool {
        x >= self.left && x <= self.right && y >= self.top && y <= self.bottom
    }

    /// Whether two rectangles share ground.
    pub(super) fn meets(&self, other: &Self) -> bool {
        self.left < other.right && other.left < self.right && self.top < other.bottom && other.top < self.bottom
    }

    /// The part of a straight piece that lies inside (Liang and Barsky).
    pub(super) fn clip(&self, from: Point, to: Point) -> Option<[Point; 2]> {
        let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
        let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
        for (step, room) in [
            (-dx, from[0] - self.left),
            (dx, self.right - from[0]),
            (-dy, from[1] - self.top),
            (dy, self.bottom - from[1]),
        ] {
            if step == 0.0 {
                if room < 0.0 {
                    return None;
                }
            } else if step < 0.0 {
                enter = enter.max(room / step);
            } else {
                leave = leave.min(room / step);
            }
        }
        (enter <= leave).then(|| [between(from, to, enter), between(from, to, leave)])
    }

    /// The pieces of a line that lie inside.
    pub(super) fn clip_line(&self, line: &[Point]) -> Vec<Vec<Point>> {
        let mut pieces: Vec<Vec<Point>> = Vec::new();
        for pair in line.windows(2) {
            let Some([from, to]) = self.clip(pair[0], pair[1]) else {
                continue;
            };
            match pieces.last_mut() {
                Some(piece) if piece.last() == Some(&from) => piece.push(to),
                _ => pieces.push(vec![from, to]),
            }
        }
        pieces
    }
}

/// Length between two points.
pub(super) fn distance(a: Point, b: Point) -> f64 {
    (b[0] - a[0]).hypot(b[1] - a[1])
}

/// The point at a fraction of the way from `a` to `b`.
pub(super) fn between(a: Point, b: Point, part: f64) -> Point {
    [a[0] + (b[0] - a[0]) * part, a[1] + (b[1] - a[1]) * part]
}

/// How far a point lies from the straight piece between two others.
pub(super) fn gap(at: Point, pair: &[Point]) -> f64 {
    let (from, to) = (pair[0], pair[1]);
    let span = [to[0] - from[0], to[1] - from[1]];
    let square = span[0] * span[0] + span[1] * span[1];
    let part = if square > 0.0 { ((at[0] - from[0]) * span[0] + (at[1] - from[1]) * span[1]) / square } else { 0.0 };
    let part = part.clamp(0.0, 1.0);
    distance(at, [from[0] + part * span[0], from[1] + part * span[1]])
}

/// `from` moved by a length along a direction.
pub(super) fn along(from: Point, direction: Point, length: f64) -> Point {
    [from[0] + direction[0] * length, from[1] + direction[1] * length]
}

/// The direction of a vector, or none for a vector of no length.
pub(super) fn unit([x, y]: Point) -> Option<Point> {
    let length = x.hypot(y);
    (length > 0.0).then(|| [x / length, y / length])
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOX: Area = Area { left: 0.0, top: 0.0, right: 10.0, bottom: 10.0 };

    #[test]
    fn dashes_cover_their_share_of_a_bent_line() {
        let line = [[0.0, 0.0], [100.0, 0.0], [100.0, 40.0]];
        let pieces = dashes(&line, Dash::Dashed);
        let drawn: f64 = pieces.iter().flat_map(|piece| piece.windows(2)).map(|pair| distance(pair[0], pair[1])).sum();
        assert_eq!(pieces.len(), 10);
        assert!((drawn - 90.0).abs() < 1e-9, "{drawn}");
        // The piece that turns the corner keeps it.
        assert!(pieces.iter().all(|piece| piece.len() == 2 || piece.contains(&[100.0, 0.0])));
    }

    #[test]
    fn a_solid_line_stays_whole() {
        let line = [[0.0, 0.0], [5.0, 5.0]];
        assert_eq!(dashes(&line, Dash::Solid), vec![line.to_vec()]);
    }

    #[test]
    fn a_line_is_cut_where_it_leaves_the_box_and_comes_back() {
        let line = [[5.0, 5.0], [15.0, 5.0], [15.0, 8.0], [5.0, 8.0]];
        assert_eq!(BOX.clip_line(&line), vec![vec![[5.0, 5.0], [10.0, 5.0]], vec![[10.0, 8.0], [5.0, 8.0]]]);
        assert_eq!(BOX.clip([-5.0, 11.0], [20.0, 11.0]), None);
    }
}
