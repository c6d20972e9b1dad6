use finray_model::gripper::Placement;
use finray_model::{Scene, Vector};
use finray_verify::grasp::{Drive, World, Partner, surface::Shape};
use finray_verify::lattice::Lattice;
use std::time::Instant;
fn main() {
    let mut args = std::env::args().skip(1);
    let mu: f64 = args.next().unwrap().parse().unwrap();
    let lift: f64 = args.next().unwrap().parse().unwrap();
    let kind = args.next().unwrap();
    let scene = Scene::from_toml(&std::fs::read_to_string("fixtures/scenes/gripper.toml").unwrap()).unwrap();
    let gripper = scene.gripper.unwrap();
    let lattice = Lattice::new(&scene.finger, 2).unwrap();
    let weight = Vector::new(0.0, 0.3);
    let drive = |deg: f64, y: f64| {
        let pose = gripper.pose(deg).unwrap();
        let outer = Placement { origin: Vector::new(0.0, y), angle_rad: 0.0, mirrored: false };
        Drive { placements: gripper.fingers(&pose).iter().map(|f| f.within(&outer)).collect::<Vec<_>>(), weight }
    };
    let shape = match kind.as_str() {
        "disc" => Shape::disc(15.0),
        _ => Shape::polygon(&[Vector::new(-15., -15.), Vector::new(15., -15.), Vector::new(15., 15.), Vector::new(-15., 15.)]),
    };
    let support = Some((Vector::new(0.0, 125.0), Vector::new(0.0, -1.0)));
    let mut world = World::new(&[&lattice, &lattice], 1.5, (shape, mu), [2.0, 110.0, 0.0], drive(300.0, 0.0), support).unwrap();
    let mut plan: Vec<(f64, f64)> = (1..60).map(|i| (300.0 - 22.5 * i as f64, 0.0)).take_while(|(d, _)| *d > -600.0).collect();
    let last = plan.last().unwrap().0;
    if lift > 0.0 {
        plan.extend((1..=10).map(|i| (last, -lift * i as f64 / 10.0)));
    }
    for (deg, y) in plan {
        let t = Instant::now();
        let outcome = world.advance(&drive(deg, y));
        let total = |p: Partner| -> Vector { world.met().iter().filter(|m| m.partner == p).map(|m| m.force).sum() };
        let (l, r, s) = (total(Partner::Finger(0)), total(Partner::Finger(1)), total(Partner::Support));
        let bal = l + r + s + weight;
        let o = world.object();
        println!("{deg:7.1} {y:6.1} {:?} obj {:.4} {:.4} {:.4} L {:.5} {:.5} R {:.5} {:.5} S {:.5} {:.5} bal {:.1e} n {} E {:.4} D {:.4} {:.0} ms", outcome.err(), o[0], o[1], o[2], l.x, l.y, r.x, r.y, s.x, s.y, bal.norm(), world.met().len(), world.elastic_nmm(), world.dissipated_nmm(), t.elapsed().as_secs_f64()*1e3);
        if outcome.is_err() { break; }
    }
}
