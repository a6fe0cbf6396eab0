use cullet_fracture::Material;
use cullet_fracture::damage::{BAND_WIDTH, Softening};
use cullet_fracture::mpm::domain::{Fields, Grip};
use cullet_fracture::mpm::{Domain, quadrature};
use cullet_fracture::particles::Particles;
use cullet_geometry::{Vec3, inside::Inside, sample, shapes};
use std::sync::Arc;
const STONE: Material = Material {
    density: 2450.0,
    young: 32e9,
    poisson: 0.2,
    failure_stress: 3e6,
    fracture_energy: 3.0,
};
fn main() {
    let a: Vec<f64> = std::env::args().skip(1).map(|s| s.parse().unwrap()).collect();
    let (h, scale, notch, seeds, single, sharp) =
        (a[0], a[1], a[2], a[3] as u64, a[4] > 0.0, a[5] > 0.0);
    let band = if a.len() > 6 { a[6] } else { BAND_WIDTH };
    let material = Material { failure_stress: 3e6 * scale, ..STONE };
    let mut all = vec![];
    for seed in 0..seeds {
        let size = Vec3::new(30.0, 14.0, 3.0) * h;
        let half = 0.5 * size.x;
        let mesh = shapes::cuboid(size, shapes::Detail::default()).unwrap();
        let inside = Inside::new(&mesh);
        let points = sample::poisson(&inside, 0.5 * h, seed).unwrap();
        let mut p = Particles::at_rest(&points, mesh.signed_volume(), material.density);
        p.volume = quadrature::volumes(&points, &inside, Vec3::repeat(h), mesh.signed_volume());
        let nd = notch * h;
        for (k, x) in points.iter().enumerate() {
            p.strength[k] = if x.x.abs() > 0.7 * half { 10.0 } else { 1.0 };
            if !sharp && x.y + 0.5 * size.y < nd && x.x.abs() < 0.5 * h {
                p.damage[k] = 1.0;
            }
        }
        let law = Softening::new(&material, band * h);
        let mut d = Domain::new(p, &material, law, Vec3::repeat(h));
        if single {
            d.fields = Fields::Single;
        }
        let speed = 0.02 * if a.len() > 7 { a[7] } else { 1.0 };
        d.launch(|x| Vec3::x() * (speed * (x.x / (0.9 * half)).clamp(-1.0, 1.0)));
        if sharp {
            d.sever(|a, b| {
                let t = a.x / (a.x - b.x);
                a.x < 0.0 && b.x > 0.0 && a.y + (b.y - a.y) * t < nd - 0.5 * size.y
            });
        }
        d.grip = Some(Grip(Arc::new(move |at: Vec3| {
            (at.x.abs() > 0.9 * half).then(|| Vec3::new(speed * at.x.signum(), 0.0, 0.0))
        })));
        let (mut e, mut peak, mut parted, mut n) = (0.0, 0.0_f64, f64::INFINITY, 0u64);
        while d.time < 1.7 * parted && n < 20000 {
            e += d.advance().dissipated;
            n += 1;
            if n % 8 == 0 {
                let st = d.stresses();
                let (mut s, mut v) = (0.0, 0.0);
                for (k, x) in d.particles.reference.iter().enumerate() {
                    if x.x.abs() < 0.35 * size.x {
                        s += st[k][0] * d.particles.volume[k];
                        v += d.particles.volume[k];
                    }
                }
                let now = s / v;
                peak = peak.max(now);
                if peak > 0.2 * law.strength && now < 0.15 * peak {
                    parted = parted.min(d.time);
                }
            }
        }
        let area = (size.y - nd) * size.z;
        // damaged layers: volume of c>0.5 outside notch / area / (h/2)
        let mut vol = 0.0;
        let mut volb = 0.0;
        for (k, x) in d.particles.reference.iter().enumerate() {
            if x.y + 0.5 * size.y > nd + h {
                if d.particles.damage[k] >= 1.0 {
                    volb += d.particles.volume[k];
                }
                if d.particles.damage[k] > 0.05 {
                    vol += d.particles.volume[k];
                }
            }
        }
        let aa = (size.y - nd - h) * size.z;
        all.push(e / (area * material.fracture_energy));
        println!(
            "seed {seed} G {:.3} peak {:.3} steps {n} parted {:.2e} broken band {:.2} h, touched {:.2} h, elastic end {:.3e} kin {:.3e} copies {}",
            all[seed as usize],
            peak / material.failure_stress,
            parted,
            volb / aa / h,
            vol / aa / h,
            d.elastic_energy(),
            d.kinetic_energy(),
            d.grid.nodes.origin.iter().enumerate().filter(|(n, o)| **o as usize != *n).count()
        );
    }
    println!("mean {:.3}", all.iter().sum::<f64>() / all.len() as f64);
}
