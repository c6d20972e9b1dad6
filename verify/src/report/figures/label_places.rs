//! Where labels go so that they hide neither lines nor each other.

use super::frame::Point;
use super::stroke::{Area, along};

/// A label looking for a place near its anchor.
#[derive(Debug, Clone, Copy)]
pub(super) struct Wish {
    /// What the label belongs to.
    pub(super) anchor: Point,
    /// The side it should stand on, of unit length.
    pub(super) side: Point,
    pub(super) width: f64,
    pub(super) height: f64,
}

/// What labels must keep off.
pub(super) struct Obstacles<'a> {
    pub(super) lines: &'a [Vec<Point>],
    pub(super) areas: Vec<Area>,
    pub(super) within: Area,
}

/// Gives each label in turn the best free place, as its centre.
///
/// Places are tried around the anchor, nearest and on the wished side first;
/// one that hides something is taken only when every other does so too.
pub(super) fn place_labels(wishes: &[Wish], mut obstacles: Obstacles) -> Vec<Point> {
    wishes
        .iter()
        .map(|wish| {
            let (_, place) = candidates(wish)
                .map(|place| (cost(wish, place, &obstacles), place))
                .min_by(|one, other| one.0.total_cmp(&other.0))
                .unwrap_or((0.0, wish.anchor));
            let taken = Area::about(place, wish.width + 4.0, wish.height + 2.0);
            obstacles.areas.push(taken);
            place
        })
        .collect()
}

fn candidates(wish: &Wish) -> impl Iterator<Item = Point> {
    let (wish, start) = (*wish, wish.side[1].atan2(wish.side[0]));
    [5.0, 9.0, 14.0, 20.0, 28.0].into_iter().flat_map(move |gap| {
        (0..24).map(move |turn| {
            let angle = start + f64::from(turn) * std::f64::consts::TAU / 24.0;
            let direction = [angle.cos(), angle.sin()];
            // So far that the label's edge, not its middle, keeps the gap.
            let reach = direction[0].abs() * wish.width / 2.0 + direction[1].abs() * wish.height / 2.0;
            along(wish.anchor, direction, gap + reach)
        })
    })
}

fn cost(wish: &Wish, place: Point, obstacles: &Obstacles) -> f64 {
    let area = Area::about(place, wish.width, wish.height);
    let roomy = Area::about(place, wish.width + 4.0, wish.height + 2.0);
    let crossed = obstacles
        .lines
        .iter()
        .flat_map(|line| line.windows(2))
        .filter(|pair| roomy.clip(pair[0], pair[1]).is_some())
        .count();
    let hidden = obstacles.areas.iter().filter(|other| other.meets(&roomy)).count();
    let within = obstacles.within;
    let outside = !(within.holds([area.left, area.top]) && within.holds([area.right, area.bottom]));
    let away = [place[0] - wish.anchor[0], place[1] - wish.anchor[1]];
    let far = away[0].hypot(away[1]);
    let turned = 1.0 - (away[0] * wish.side[0] + away[1] * wish.side[1]) / far.max(1e-9);
    100.0 * crossed as f64 + 200.0 * hidden as f64 + 1000.0 * f64::from(outside) + far + 18.0 * turned
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHEET: Area = Area { left: 0.0, top: 0.0, right: 400.0, bottom: 200.0 };

    fn wish(anchor: Point) -> Wish {
        Wish { anchor, side: [0.0, -1.0], width: 30.0, height: 16.0 }
    }

    #[test]
    fn crowded_labels_hide_neither_each_other_nor_the_line() {
        let line = vec![vec![[20.0, 100.0], [380.0, 100.0]]];
        let wishes: Vec<Wish> = (0..8).map(|i| wish([60.0 + 14.0 * f64::from(i), 100.0])).collect();
        let places = place_labels(&wishes, Obstacles { lines: &line, areas: vec![], within: SHEET });
        let areas: Vec<Area> = places.iter().map(|place| Area::about(*place, 30.0, 16.0)).collect();
        for (index, area) in areas.iter().enumerate() {
            assert!(area.clip(line[0][0], line[0][1]).is_none());
            assert!(areas[..index].iter().all(|other| !other.meets(area)));
        }
    }

    #[test]
    fn a_label_with_room_stands_on_the_side_it_wished_for() {
        let free = Obstacles { lines: &[], areas: vec![], within: SHEET };
        let place = place_labels(&[wish([200.0, 100.0])], free)[0];
        assert!((place[0] - 200.0).abs() < 1e-9 && place[1] < 100.0);
    }

    #[test]
    fn a_label_stays_on_the_sheet() {
        let free = Obstacles { lines: &[], areas: vec![], within: SHEET };
        let place = place_labels(&[wish([200.0, 4.0])], free)[0];
        assert!(place[1] >= 8.0);
    }
}
