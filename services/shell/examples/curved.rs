use cullet_geometry::shapes::{self, Detail};
use cullet_geometry::{Solid, Vec3};
use cullet_model::*;
use cullet_shell::solve::ShellSolve;
use cullet_simd::SimdLevel;
use std::fmt::Write;
use std::sync::Arc;
fn env(k: &str, d: f64) -> f64 { std::env::var(k).ok().and_then(|v| v.parse().ok()).unwrap_or(d) }
fn arc(c: [f64; 2], r: f64, from: f64, to: f64, n: usize) -> Vec<[f64; 2]> {
    (0..=n).map(|k| { let a = (from + (to - from) * k as f64 / n as f64).to_radians(); [c[0] + r * a.cos(), c[1] + r * a.sin()] }).collect()
}
fn main() {
    let glass = Material { density: 2480.0, young: 74e9, poisson: 0.23, failure_stress: env("SF", 50e6), fracture_energy: env("GF", 7.4) };
    let kind = std::env::var("KIND").unwrap_or("bottle".into());
    let (profile, t, point, normal): (Vec<[f64; 2]>, f64, Vec3, Vec3) = match kind.as_str() {
        "bottle" => { let mut p = vec![[0.0, 0.0], [0.010, 0.0], [0.020, 0.0]]; p.extend(arc([0.027, 0.010], 0.010, -90.0, 0.0, 6)); p.extend([[0.037, 0.06], [0.037, 0.12]]);
            p.extend(arc([0.022, 0.15], 0.015, 0.0, 60.0, 6)); p.push([0.014, 0.20]); p.push([0.014, 0.25]); (p, 0.003, Vec3::new(0.0385, 0.0, 0.09), -Vec3::x()) }
        "bowl" => (arc([0.0, 0.08], 0.08, -90.0, 0.0, 24), 0.004, Vec3::new(0.0, 0.0, -0.002), Vec3::z()),
        _ => (arc([0.0, 0.0], 0.022, -90.0, 90.0, 24), 0.0006, Vec3::new(0.0223, 0.0, 0.0), -Vec3::x()),
    };
    let mesh = shapes::lathe_midline(&profile, t, Detail { edge: None, segments: 64, ..Detail::default() }).unwrap();
    let mass0 = mesh.mass_properties(); let c = mass0.centroid;
    let mut mesh = mesh; mesh.vertices.iter_mut().for_each(|x| *x -= c); let point = point - c;
    println!("{kind}: volume {:.3e}, mass {:.3} kg, {} triangles", mesh.signed_volume(), mesh.signed_volume() * glass.density, mesh.triangles.len());
    let body = glass.density * mesh.signed_volume();
    let (r, v) = (env("R", 0.012), env("V", 8.0));
    let mass = 7850.0 * 4.0 / 3.0 * std::f64::consts::PI * r.powi(3) * env("HEAVY", 1.0);
    let reduced = 1.0 / (1.0 / mass + 1.0 / body);
    let modulus = 1.0 / ((1.0 - 0.09) / 200e9 + (1.0 - 0.23 * 0.23) / 74e9);
    let stiffness = 4.0 / 3.0 * modulus * r.sqrt();
    let approach = (1.25 * reduced * v * v / stiffness).powf(0.4);
    let hit = Impact { point, normal, impulse: 2.0 * reduced * v, duration: 2.9433 * approach / v, radius: (r * approach).sqrt(), energy: 0.5 * reduced * v * v, closing_speed: v, crushing_pressure: 1e12 };
    let spacing = std::env::var("L").ok().map(|v| v.parse().unwrap());
    let settings = Settings { spacing, max_particles: 60000, max_steps: 100000, precision: PointPrecision::Double, ..Settings::default() };
    let problem = BrittleProblem { solid: Arc::new(Solid::outer(mesh)), material: glass,
        strength: StrengthField { weibull: env("M", 7.0), seed: env("SEED", 4.0) as u64, ..StrengthField::even() },
        impacts: vec![hit], supports: vec![], spin: Vec3::zeros(), settings, seed: env("SEED", 1.0) as u64 };
    let start = std::time::Instant::now();
    let mut solve = match ShellSolve::<f64, 16>::of_curved(problem, SimdLevel::best()) { Ok(s) => s, Err(e) => { println!("REFUSED {e}"); return } };
    println!("ready after {:.1} s, {} nodes, {} points, step {:.3e}", start.elapsed().as_secs_f64(), solve.domain.mass.len(), solve.domain.points(), solve.domain.step);
    let found = loop { match solve.advance() { Progress::Running(_) => {}, Progress::Done(o) => break Some(o.fracture().unwrap()), Progress::Failed(f) => { println!("FAILED {f}"); break None } } };
    let (all, damaged, broken, dead) = draw(&solve);
    println!("damaged {:.2} broken {:.3} dead {:.3} of {all}, {:.1} s", damaged as f64 / all as f64, broken as f64 / all as f64, dead as f64 / all as f64, start.elapsed().as_secs_f64());
    let Some(found) = found else { return };
    let detail = |n: &str| found.report.detail(n).unwrap_or(f64::NAN);
    println!("{} pieces, sampled {}, debris {}, crack {:.4} m2, balance {:.3}, delivered {:.3} of {:.3}, steps {}, simulated {:.2e}", found.fragments.len(), found.sampled.iter().filter(|s| **s).count(), found.debris.len(), found.report.crack_area,
        detail("energy_balance"), detail("delivered_impulse"), 2.0 * reduced * v, found.report.steps, found.report.simulated);
    for w in &found.report.warnings { println!("  {w}"); }
}
fn draw(solve: &ShellSolve<f64, 16>) -> (usize, usize, usize, usize) {
    let d = &solve.domain;
    let mut items = vec![];
    let (mut all, mut damaged, mut broken, mut dead) = (0, 0, 0, 0);
    let parts = d.parts(8);
    let views = [0.0_f64, 120.0, 240.0].map(|a| { let a = a.to_radians(); let eye = Vec3::new(a.cos(), a.sin(), if std::env::var("KIND").as_deref() == Ok("bowl") { -1.0 } else { 0.35 }).normalize(); let right = Vec3::z().cross(&eye).normalize(); (eye, right, eye.cross(&right)) });
    let size = d.live().map(|p| d.surface.surface_point(p).place.norm()).fold(0.0, f64::max);
    for p in d.live() {
        let s = d.state(p); let at = d.surface.surface_point(p); all += 1;
        let hue = parts[p].map(|k| (k * 67) % 360);
        let colour = if s.dead { dead += 1; "red".to_string() } else if s.is_broken() { broken += 1; match s.crack { Some(c) if c.side < 0.0 => "blue".into(), _ => "black".into() } } else if s.damage > 0.0 { damaged += 1; format!("rgb({0},{0},{0})", 200 - (s.damage * 150.0) as u32) } else { hue.map_or("gray".into(), |h| format!("hsl({h},60%,80%)")) };
        let w = at.area.sqrt() / size * 290.0 * 1.2;
        for (k, (eye, right, up)) in views.iter().enumerate() {
            if at.normal.dot(eye) > 0.0 { items.push((at.place.dot(eye), format!("<rect x='{:.1}' y='{:.1}' width='{w:.1}' height='{w:.1}' fill='{colour}'/>", 300.0 + k as f64 * 600.0 + at.place.dot(right) / size * 290.0 - w / 2.0, 300.0 - at.place.dot(up) / size * 290.0 - w / 2.0))); }
        }
    }
    items.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut svg = String::from("<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 1800 600' width='1800' height='600'><rect width='1800' height='600' fill='white'/>");
    for (_, i) in items { let _ = write!(svg, "{i}"); }
    svg.push_str("</svg>");
    std::fs::write(std::env::var("OUT").unwrap_or("/tmp/wt/draw/curved.svg".into()), svg).unwrap();
    (all, damaged, broken, dead)
}
