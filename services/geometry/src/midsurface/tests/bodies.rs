//! Thin walls and what looks like them.

use crate::boolean::Exact;
use crate::math::Vec3;
use crate::mesh::{Solid, TriMesh};
use crate::shapes::{Detail, extrude, lathe_shell, lathe_solid, sphere, torus};
use std::f64::consts::{FRAC_PI_2, PI};

/// A hollow ball of outer radius 50 mm and wall 3 mm.
pub(super) fn hollow_ball(segments: u32) -> TriMesh {
    let detail = Detail { segments, edge: None };
    let mut ball = sphere(0.05, detail).unwrap();
    ball.append(&sphere(0.047, detail).unwrap().flipped());
    ball
}

/// An arc about `centre` from angle `from` to `to` \[rad\], both ends included.
fn arc(centre: [f64; 2], radius: f64, from: f64, to: f64, parts: u32) -> Vec<[f64; 2]> {
    let at = |i: u32| from + (to - from) * f64::from(i) / f64::from(parts);
    let point = |a: f64| [centre[0] + radius * libm::cos(a), centre[1] + radius * libm::sin(a)];
    (0..=parts).map(|i| point(at(i))).collect()
}

/// A profile from the axis to the axis: an egg 56 mm long.
pub(super) fn egg_midline() -> Vec<[f64; 2]> {
    let point = |i: u32| {
        let a = PI * f64::from(i) / 40.0;
        let (sin, cos) = (libm::sin(a), libm::cos(a));
        let on_axis = i == 0 || i == 40;
        [if on_axis { 0.0 } else { 0.022 * sin * (1.0 + 0.15 * cos) }, -0.028 * cos]
    };
    (0..=40).map(point).collect()
}

/// Half a ball of outer radius 80 mm, wall 4 mm, with a flat rim or a round one.
pub(super) fn bowl(round_rim: bool, segments: u32) -> TriMesh {
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

/// As the bowl, with a wall from 2 mm at the rim to 6 mm at the bottom.
pub(super) fn uneven_bowl() -> TriMesh {
    let mut section = arc([0.0, 0.0], 0.08, -FRAC_PI_2, 0.0, 16);
    section[0][0] = 0.0;
    let inner = (0..=16).map(|i| {
        let share = f64::from(i) / 16.0;
        let (radius, a) = (0.078 - 0.004 * share, -FRAC_PI_2 * share);
        [if i == 16 { 0.0 } else { radius * libm::cos(a) }, radius * libm::sin(a)]
    });
    section.extend(inner);
    lathe_solid(&section, Detail { segments: 64, edge: None }).unwrap()
}

/// The profile of a bottle 200 mm high and 74 mm wide, moved inwards by `depth` \[m\]: heel, wall,
/// shoulder, and neck by an arc bent the other way.
fn bottle_profile(depth: f64) -> Vec<[f64; 2]> {
    let mut profile = vec![[0.0, depth]];
    profile.extend(arc([0.027, 0.010], 0.010 - depth, -FRAC_PI_2, 0.0, 6));
    profile.extend(arc([0.0, 0.110], 0.037 - depth, 0.0, 0.6, 8));
    let reach = 0.037 + 0.030;
    let centre = [reach * libm::cos(0.6), 0.110 + reach * libm::sin(0.6)];
    profile.extend(&arc(centre, 0.030 + depth, PI + 0.6, PI, 6)[1..]);
    profile.push([centre[0] - 0.030 - depth, 0.200]);
    profile
}

/// The bottle with a wall of 3 mm.
pub(super) fn bottle(segments: u32) -> TriMesh {
    lathe_shell(&bottle_profile(0.0), 0.003, Detail { segments, edge: None }).unwrap()
}

pub(super) fn bottle_midline() -> Vec<[f64; 2]> {
    bottle_profile(0.0015)
}

/// The distance of a point from a surface of revolution \[m\].
pub(super) fn distance_to_profile(p: Vec3, profile: &[[f64; 2]]) -> f64 {
    let (r, z) = (p.xy().norm(), p.z);
    let from = |a: [f64; 2], b: [f64; 2]| {
        let (x, y) = (b[0] - a[0], b[1] - a[1]);
        let share = ((r - a[0]) * x + (z - a[1]) * y) / (x * x + y * y);
        let share = share.clamp(0.0, 1.0);
        (r - a[0] - share * x).hypot(z - a[1] - share * y)
    };
    profile.windows(2).map(|w| from(w[0], w[1])).fold(f64::MAX, f64::min)
}

/// A pane of 0.6 m by 0.4 m and 5 mm, bent to a radius of 1.5 m about z.
pub(super) fn windscreen() -> TriMesh {
    let (from, to) = (FRAC_PI_2 - 0.2, FRAC_PI_2 + 0.2);
    let mut outline = arc([0.0, 0.0], 1.5025, from, to, 24);
    outline.extend(arc([0.0, 0.0], 1.4975, to, from, 24));
    extrude(&outline, 0.4, Detail::default()).unwrap()
}

/// A plate of 200 mm by 200 mm and 5 mm with a rib 40 mm high and 8 mm wide in its middle.
pub(super) fn ribbed_plate() -> TriMesh {
    let outline = [
        [-0.1, 0.0],
        [0.1, 0.0],
        [0.1, 0.005],
        [0.004, 0.005],
        [0.004, 0.045],
        [-0.004, 0.045],
        [-0.004, 0.005],
        [-0.1, 0.005],
    ];
    extrude(&outline, 0.2, Detail::default()).unwrap()
}

/// A mug of wall 4 mm with a solid handle 16 mm thick.
pub(super) fn mug() -> TriMesh {
    let profile = [[0.0, 0.0], [0.04, 0.0], [0.04, 0.09]];
    let cup = lathe_shell(&profile, 0.004, Detail::default()).unwrap();
    // The ring stands upright beside the wall; what reaches into the cup is cut off.
    let mut ring = torus(0.028, 0.008, Detail { segments: 32, edge: None }).unwrap();
    ring.vertices.iter_mut().for_each(|p| *p = Vec3::new(p.x + 0.044, p.z, p.y + 0.045));
    let ring = Exact::new(&Solid::outer(ring.flipped())).unwrap();
    let body =
        Exact::new(&Solid::outer(lathe_solid(&profile, Detail::default()).unwrap())).unwrap();
    let cup = Exact::new(&Solid::outer(cup)).unwrap();
    cup.union(&ring.subtract(&body).unwrap()).unwrap().mesh()
}
