use cullet_fracture::Material;
use cullet_fracture::solver::{Impact, Problem, Progress, Settings, Solver};
use cullet_fracture::solvers::brittle::Brittle;
use cullet_geometry::{Solid, Vec3, shapes};
use std::sync::Arc;
use std::time::Instant;
fn main() {
    let a: Vec<f64> = std::env::args().skip(1).map(|s| s.parse().unwrap()).collect();
    let (n, j, v) = (a[0] as u32, a[1], a[2]);
    let plaster = Material {
        density: 1200.0,
        young: 3e9,
        poisson: 0.2,
        failure_stress: 3e6,
        fracture_energy: 5.0,
    };
    let mesh = shapes::cuboid(Vec3::new(0.1, 0.1, 0.2), shapes::Detail::default()).unwrap();
    let solid = Arc::new(Solid::outer(mesh));
    let impact = Impact {
        point: Vec3::new(-0.05, 0.004, 0.01),
        normal: Vec3::x(),
        impulse: j,
        duration: 1.5e-4,
        radius: 0.006,
        energy: 0.5 * j * v,
        closing_speed: v,
    };
    let problem = Problem {
        solid,
        material: plaster,
        impacts: vec![impact],
        settings: Settings { max_particles: n, ..Settings::default() },
        seed: 1,
    };
    let t = Instant::now();
    let mut s = Brittle::begin(problem).unwrap();
    println!("begin {:.2} s", t.elapsed().as_secs_f64());
    let t = Instant::now();
    loop {
        let before = t.elapsed().as_secs_f64();
        match s.advance() {
            Progress::Running(x) => {
                let _ = (x, before);
            }
            Progress::Done(f) => {
                let r = &f.report;
                println!(
                    "last slice + cut {:.2} s; total {:.2} s: {} particles {} steps {:.2} M/s; {} fragments, dissipated {:.3} crack {:.4} J, damaged {:.3}",
                    t.elapsed().as_secs_f64() - before,
                    t.elapsed().as_secs_f64(),
                    r.particles,
                    r.steps,
                    r.particles as f64 * r.steps as f64 / before / 1e6,
                    f.fragments.len(),
                    r.dissipated_energy,
                    r.fracture_energy,
                    r.damaged_fraction
                );
                for w in &r.warnings {
                    println!("  {w}");
                }
                let d = s.domain();
                let pieces = d.pieces();
                let n = pieces.iter().flatten().max().map_or(0, |m| *m as usize + 1);
                let mut size = vec![0u32; n];
                for &x in pieces.iter().flatten() {
                    size[x as usize] += 1;
                }
                let mut big: Vec<u32> = size.iter().copied().filter(|&s| s >= 8).collect();
                big.sort();
                big.reverse();
                println!(
                    "  pieces {n}; of at least 8: {} holding {:.3}; {:?}",
                    big.len(),
                    big.iter().sum::<u32>() as f64 / pieces.len() as f64,
                    &big[..big.len().min(30)]
                );
                let mut out = String::new();
                let st = d.stresses();
                let m = d.motions();
                for (k, x) in d.particles.reference.iter().enumerate() {
                    let (v, _) = cullet_fracture::mpm::symmetric::eigen(&st[k]);
                    let big = v[0].max(v[1]).max(v[2]);
                    out += &format!(
                        "{} {} {} {} {} {} {}\n",
                        x.x,
                        x.y,
                        x.z,
                        d.particles.damage[k],
                        d.particles.damage_time[k],
                        big,
                        m[k].velocity.norm()
                    );
                }
                std::fs::write("/tmp/points.txt", out).unwrap();
                break;
            }
            Progress::Failed(e) => {
                println!("{e}");
                break;
            }
        }
    }
}
