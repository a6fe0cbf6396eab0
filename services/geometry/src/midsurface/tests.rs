//! Midsurfaces of bodies with known middles, and of bodies that have none.

use super::*;
use crate::remesh::tests::MeshQuality;
use crate::shapes::{Detail, cuboid, extrude, lathe_shell, lathe_solid, sphere};
use std::f64::consts::{FRAC_PI_2, PI};

/// A hollow ball of outer radius 50 mm and wall 3 mm.
pub(crate) fn hollow_ball(segments: u32) -> TriMesh {
    let detail = Detail { segments, edge: None };
    let mut ball = sphere(0.05, detail).unwrap();
    ball.append(&sphere(0.047, detail).unwrap().flipped());
    ball
}

/// A quarter circle about `centre` from angle `from` to `to` \[rad\], both ends included.
fn arc(centre: [f64; 2], radius: f64, from: f64, to: f64, parts: u32) -> Vec<[f64; 2]> {
    let at = |i: u32| from + (to - from) * f64::from(i) / f64::from(parts);
    let point = |a: f64| [centre[0] + radius * libm::cos(a), centre[1] + radius * libm::sin(a)];
    (0..=parts).map(|i| point(at(i))).collect()
}

/// Half a ball of outer radius 80 mm, wall 4 mm, with a flat rim or a round one.
fn bowl(round_rim: bool, segments: u32) -> TriMesh {
    let mut section = arc([0.0, 0.0], 0.08, -FRAC_PI_2, 0.0, segments / 4);
    section[0][0] = 0.0;
    if round_rim {
        section.extend(&arc([0.078, 0.0], 0.002, 0.0, PI, 8)[1..8]);
    }
    let mut inner = arc([0.0, 0.0], 0.076, 0.0, -FRAC_PI_2, segments / 4);
    inner.last_mut().unwrap()[0] = 0.0;
    section.extend(inner);
    lathe_solid(&section, Detail { segments, edge: None }).unwrap()
}

/// The outer profile of a bottle 200 mm high, of radius 37 mm.
pub(crate) fn bottle_profile() -> Vec<[f64; 2]> {
    let mut profile = vec![[0.0, 0.0]];
    profile.extend(arc([0.027, 0.010], 0.010, -FRAC_PI_2, 0.0, 6));
    profile.extend(arc([0.0, 0.110], 0.037, 0.0, 0.6, 8));
    // Out of the shoulder's arc into the neck's, bent the other way.
    let (r, z) = (0.037 * libm::cos(0.6), 0.110 + 0.037 * libm::sin(0.6));
    let bend = 0.030;
    let centre = [r + bend * libm::cos(0.6), z + bend * libm::sin(0.6)];
    profile.extend(&arc(centre, bend, PI + 0.6, PI, 6)[1..]);
    let radius = centre[0] - bend;
    profile.push([radius, 0.200]);
    profile
}

fn bottle(segments: u32) -> TriMesh {
    lathe_shell(&bottle_profile(), 0.003, Detail { segments, edge: None }).unwrap()
}

/// A pane of 0.6 m by 0.4 m and 5 mm, bent to a radius of 1.5 m.
fn windscreen() -> TriMesh {
    let half = 0.2;
    let mut outline = arc([0.0, 0.0], 1.5025, FRAC_PI_2 - half, FRAC_PI_2 + half, 24);
    outline.extend(arc([0.0, 0.0], 1.4975, FRAC_PI_2 + half, FRAC_PI_2 - half, 24));
    extrude(&outline, 0.4, Detail::default()).unwrap()
}

fn report(name: &str, surface: &WallSurface, spacing: f64) {
    let q = MeshQuality::of(&surface.mesh(), spacing);
    eprintln!("{name}: {} vertices, area {:.6}, volume {:.4e}, sharp {:.3}, loops {:?} {q:?}",
        surface.vertices.len(), surface.area(), surface.volume(), surface.sharp_share(),
        surface.boundary().iter().map(Vec::len).collect::<Vec<_>>());
}

#[test]
fn figures() {
    let bodies: Vec<(&str, TriMesh, f64)> = vec![
        ("ball", hollow_ball(48), 0.006),
        ("ball fine", hollow_ball(64), 0.003),
        ("bowl flat", bowl(false, 64), 0.006),
        ("bowl round", bowl(true, 64), 0.006),
        ("bottle 3", bottle(64), 0.003),
        ("bottle 6", bottle(64), 0.006),
        ("windscreen", windscreen(), 0.01),
        ("pot", lathe_shell(&[[0.0, 0.0], [0.05, 0.0], [0.05, 0.1]], 0.003, Detail::default()).unwrap(), 0.005),
    ];
    for (name, mesh, spacing) in bodies {
        let start = std::time::Instant::now();
        let found = WallSurface::of_mesh(&mesh, spacing);
        eprintln!("{name} {:.2} s, V {:.4e}", start.elapsed().as_secs_f64(), mesh.signed_volume());
        match found {
            Ok(surface) => {
                report(name, &surface, spacing);
                let mut obj = String::new();
                for p in &surface.vertices { obj += &format!("v {} {} {}\n", p.x, p.y, p.z); }
                for t in &surface.triangles { obj += &format!("f {} {} {}\n", t[0]+1, t[1]+1, t[2]+1); }
                std::fs::write(format!("/tmp/wall_{}.obj", name.replace(' ', "_")), obj).unwrap();
            }
            Err(e) => eprintln!("{name} refused: {e}"),
        }
    }
    let _ = cuboid;
}
