use finray_verify::contact_scene::*;
use finray_model::*;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let text = finray_verify::fixtures::PAPER_SCENE.to_owned() + "\n[object]\n" + &a[2].replace(';', "\n");
    let scene = Scene::from_toml(&text).unwrap();
    let object = scene.object.clone().unwrap();
    let cs = ContactScene::new(&scene, &object, &[]).unwrap().with_fineness(a[1].parse().unwrap());
    let mut t = std::time::Instant::now();
    let r = cs.run(|s| {
        let c = s.pressed.contact_force();
        println!("travel {:.3} {:?} steps {} F {:.4} hand {:.1e} base {:.1e}", s.travel_mm, t.elapsed(), s.pressed.steps, c.norm(), (c-s.pressed.hand_force).norm()/c.norm(), (c-s.pressed.base_force).norm()/c.norm());
        t = std::time::Instant::now();
        match cs.sense(&s, 0.0, || 0.0) {
            Ok(Some(x)) => { for (f, c) in x.forces.iter().zip(&s.contacts) { println!("   {} true {:.4} friction {:.3} sensed {:.4} ({:+.2} %)", c.contact, f.true_n, c.friction_n, f.sensed_n, 100.*f.relative_error()); }
                println!("   total true {:.4} sensed {:.4} ({:+.2} %)", x.total.true_n, x.total.sensed_n, 100.*x.total.relative_error()); }
            other => println!("   {other:?}"),
        }
        let mut n = standard_normal(1);
        let (mut k, mut z2, mut in2, mut zt2, mut it) = (0, 0.0, 0, 0.0, 0); let mut m = 0;
        for _ in 0..200 { match cs.sense(&s, 0.067, &mut n) { Ok(Some(x)) => { for f in &x.forces { k+=1; let z = f.standardised_error(); z2 += z*z; if z.abs()<1.96 {in2+=1;} } m+=1; let z = x.total.standardised_error(); zt2+=z*z; if z.abs()<1.96 {it+=1;} }, _ => {} } }
        println!("   noise: answered {m}; each z rms {:.2} cover {:.3}; total z rms {:.2} cover {:.3}", (z2/k as f64).sqrt(), in2 as f64/k as f64, (zt2/m as f64).sqrt(), it as f64/m as f64);
    });
    println!("{r:?}");
}
