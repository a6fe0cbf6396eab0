use super::crack::area;
use super::{SheetTriangulation, SurfaceTie, TornSurface};
use cullet_geometry::Vec3;
use cullet_geometry::math::unit;
use cullet_model::membrane::SheetPlace;
use std::collections::BTreeMap;

const SPACING: f64 = 0.01;

fn rectangle() -> Vec<SheetPlace> {
    vec![[0.02, -0.1], [0.36, -0.1], [0.36, 0.13], [0.02, 0.13]]
}

fn corner_piece() -> Vec<SheetPlace> {
    vec![[0.0, 0.0], [0.3, 0.0], [0.3, 0.111], [0.1234, 0.111], [0.1234, 0.3], [0.0, 0.3]]
}

fn disc() -> Vec<SheetPlace> {
    let turn = |k: u32| f64::from(k) * std::f64::consts::TAU / 64.0;
    (0..64).map(|k| [0.15 * turn(k).cos(), 0.15 * turn(k).sin()]).collect()
}

/// A square with a slit so narrow that the nearest point is often across it.
fn slit() -> Vec<SheetPlace> {
    let lips = [[0.2, 0.1], [0.08, 0.1003], [0.2, 0.1008]];
    [&[[0.0, 0.0], [0.2, 0.0]], &lips[..], &[[0.2, 0.2], [0.0, 0.2]]].concat()
}

fn outlines() -> [(&'static str, Vec<SheetPlace>); 4] {
    [
        ("rectangle", rectangle()),
        ("corner piece", corner_piece()),
        ("disc", disc()),
        ("slit", slit()),
    ]
}

fn outline_area(outline: &[SheetPlace]) -> f64 {
    let next = |k: usize| outline[(k + 1) % outline.len()];
    (0..outline.len()).map(|k| area(outline[0], outline[k], next(k))).sum()
}

fn sides(outline: &[SheetPlace]) -> impl Iterator<Item = [SheetPlace; 2]> {
    (0..outline.len()).map(|k| [outline[k], outline[(k + 1) % outline.len()]])
}

fn distance_to([a, b]: [SheetPlace; 2], p: SheetPlace) -> f64 {
    let along = [b[0] - a[0], b[1] - a[1]];
    let dot = (p[0] - a[0]) * along[0] + (p[1] - a[1]) * along[1];
    let t = (dot / (along[0] * along[0] + along[1] * along[1])).clamp(0.0, 1.0);
    (p[0] - a[0] - t * along[0]).hypot(p[1] - a[1] - t * along[1])
}

/// Rows of points shaken by half the spacing, which is less even than sheets have them; none is
/// nearer to the outline than a third of it.
fn scatter(outline: &[SheetPlace], spacing: f64) -> Vec<SheetPlace> {
    let mut points = Vec::new();
    for key in 0..200_u64 * 200 {
        let shake = |stream| 0.98 * unit(5, stream, key) - 0.49;
        let x = ((key % 200) as f64 - 100.0 + 0.5 + shake(0)) * spacing;
        let y = ((key / 200) as f64 - 100.0 + 0.5 + shake(1)) * spacing;
        let crossed = sides(outline).filter(|&[a, b]| {
            (a[1] > y) != (b[1] > y) && x < a[0] + (b[0] - a[0]) * (y - a[1]) / (b[1] - a[1])
        });
        let inside = crossed.count() % 2 == 1;
        if inside && sides(outline).all(|side| distance_to(side, [x, y]) > spacing / 3.0) {
            points.push([x, y]);
        }
    }
    points
}

struct Sample {
    points: Vec<SheetPlace>,
    outline: Vec<SheetPlace>,
    mesh: SheetTriangulation,
}

impl Sample {
    fn new(outline: Vec<SheetPlace>) -> Self {
        let points = scatter(&outline, SPACING);
        let mesh = SheetTriangulation::new(&points, &outline, SPACING).expect("a sheet");
        Self { points, outline, mesh }
    }

    /// Flags with those pairs false that a line crosses.
    fn torn_along(&self, line: &[SheetPlace]) -> Vec<bool> {
        let crossed = |&[i, j]: &[u32; 2]| {
            let (p, q) = (self.points[i as usize], self.points[j as usize]);
            line.windows(2).any(|ab| {
                let apart = |a, b, c, d| (area(a, b, c) > 0.0) != (area(a, b, d) > 0.0);
                apart(p, q, ab[0], ab[1]) && apart(ab[0], ab[1], p, q)
            })
        };
        self.mesh.pairs().iter().map(|pair| !crossed(pair)).collect()
    }

    fn torn_at_random(&self, share: f64) -> Vec<bool> {
        (0..self.mesh.pairs().len() as u64).map(|pair| unit(3, 7, pair) >= share).collect()
    }

    fn tears(&self) -> Vec<(&'static str, Vec<bool>)> {
        let whole = vec![true; self.mesh.pairs().len()];
        let none = vec![false; self.mesh.pairs().len()];
        vec![
            ("whole", whole),
            ("half torn", self.torn_along(&[[-1.0, 0.03], [0.09, 0.051]])),
            ("torn through", self.torn_along(&[[-1.0, 0.03], [1.0, 0.051]])),
            ("5 % at random", self.torn_at_random(0.05)),
            ("60 % at random", self.torn_at_random(0.6)),
            ("cut to points", none),
        ]
    }

    /// Places of the points, moved by a map, and its gradients.
    fn moved(&self, map: impl Fn(usize) -> ([Vec3; 2], Vec3)) -> (Vec<Vec3>, Vec<[Vec3; 2]>) {
        let place = |(i, &[x, y]): (usize, &SheetPlace)| {
            let ([along_x, along_y], shift) = map(i);
            (along_x * x + along_y * y + shift, [along_x, along_y])
        };
        self.points.iter().enumerate().map(place).unzip()
    }
}

/// Places at rest, in double precision.
fn at_rest(sample: &Sample, torn: &TornSurface) -> Vec<SheetPlace> {
    let place = |tie: &SurfaceTie| {
        let [x, y] = sample.points[tie.point as usize];
        [x + tie.offset[0], y + tie.offset[1]]
    };
    (0..torn.surface.reference.len() as u32).map(|v| place(&torn.ties(v)[0])).collect()
}

fn for_each_tear(mut check: impl FnMut(&str, &Sample, &[bool], &TornSurface)) {
    for (shape, outline) in outlines() {
        let sample = Sample::new(outline);
        for (tear, alive) in sample.tears() {
            let torn = TornSurface::new(&sample.mesh, &alive, 0.0);
            check(&format!("{shape}, {tear}"), &sample, &alive, &torn);
        }
    }
}

#[test]
fn its_area_at_rest_is_that_of_the_outline() {
    for_each_tear(|name, sample, _, torn| {
        let rest = at_rest(sample, torn);
        let areas = torn.surface.triangles.iter().map(|t| {
            let [a, b, c] = t.map(|v| rest[v as usize]);
            area(a, b, c)
        });
        let (mut sum, mut least) = (0.0, f64::MAX);
        for one in areas {
            sum += one;
            least = least.min(one);
        }
        let error = sum / outline_area(&sample.outline) - 1.0;
        assert!(error.abs() < 1e-12, "{name}: area off by {error:e}");
        assert!(least > 0.0, "{name}: a triangle of {least:e} m² is turned over");
    });
}

#[test]
fn lips_fit_where_the_sheet_moves_as_one() {
    let stretched = [Vec3::new(1.1, 0.2, -0.3), Vec3::new(-0.1, 0.9, 0.4)];
    for gradient in [[Vec3::x(), Vec3::y()], stretched] {
        for_each_tear(|name, sample, _, torn| {
            let (x, gradients) = sample.moved(|_| (gradient, Vec3::new(0.0, 0.0, 0.5)));
            let places = torn.places(&x, &gradients);
            let mut here: BTreeMap<[u32; 2], Vec3> = BTreeMap::new();
            let mut copies = 0;
            for (place, rest) in places.iter().zip(&torn.surface.reference) {
                let first = here.insert(rest.map(f32::to_bits), *place);
                copies += usize::from(first.is_some());
                let gap = (first.unwrap_or(*place) - place).norm();
                assert!(gap < 1e-15, "{name}: a gap of {gap:e} m at {rest:?}");
            }
            assert!(name.ends_with("whole") || copies > 10, "{name}: {copies} lips");
        });
    }
}

#[test]
fn a_vertex_is_in_the_middle_of_where_its_points_have_it() {
    for_each_tear(|name, sample, _, torn| {
        let (x, gradients) = sample.moved(|i| {
            let wild = |stream| unit(11, stream, i as u64) - 0.5;
            let vector = |k| Vec3::new(wild(k), wild(k + 1), wild(k + 2));
            ([vector(0), vector(3)], vector(6))
        });
        let places = torn.places(&x, &gradients);
        assert_eq!(places[..x.len()], x, "{name}");
        assert_eq!(places.len(), torn.surface.reference.len(), "{name}");
        let rest = at_rest(sample, torn);
        for (v, place) in places.iter().enumerate() {
            let ties = torn.ties(v as u32);
            let maps = ties.iter().map(|tie| {
                let i = tie.point as usize;
                let ([p, q], [u, v]) = (sample.points[i], rest[v]);
                x[i] + gradients[i][0] * (u - p) + gradients[i][1] * (v - q)
            });
            let middle = maps.sum::<Vec3>() / ties.len() as f64;
            assert!((middle - place).norm() < 1e-15, "{name}");
        }
    });
}

/// Labels of what hangs together, one for each item.
fn components(count: usize, joints: impl Iterator<Item = [usize; 2]>) -> Vec<usize> {
    let mut parent: Vec<usize> = (0..count).collect();
    fn root(parent: &mut [usize], mut at: usize) -> usize {
        while parent[at] != at {
            parent[at] = parent[parent[at]];
            at = parent[at];
        }
        at
    }
    for [a, b] in joints {
        let (a, b) = (root(&mut parent, a), root(&mut parent, b));
        parent[a.max(b)] = a.min(b);
    }
    (0..count).map(|at| root(&mut parent, at)).collect()
}

fn point_components(sample: &Sample, alive: &[bool]) -> Vec<usize> {
    let pairs = sample.mesh.pairs().iter().zip(alive).filter(|(_, alive)| **alive);
    components(sample.points.len(), pairs.map(|(pair, _)| pair.map(|i| i as usize)))
}

/// The triangles at each edge, by its ends in the order in which the triangle has them.
fn directed_edges(torn: &TornSurface) -> BTreeMap<[u32; 2], usize> {
    let mut found = BTreeMap::new();
    for (t, &[a, b, c]) in torn.surface.triangles.iter().enumerate() {
        for edge in [[a, b], [b, c], [c, a]] {
            assert!(found.insert(edge, t).is_none(), "two triangles on one side of an edge");
        }
    }
    found
}

#[test]
fn it_hangs_together_as_its_points_do() {
    for_each_tear(|name, sample, alive, torn| {
        let edges = directed_edges(torn);
        let joints = edges.iter().filter_map(|(&[a, b], &t)| Some([t, *edges.get(&[b, a])?]));
        let mut parts = components(torn.surface.triangles.len(), joints);
        parts.sort_unstable();
        parts.dedup();
        let mut pieces = point_components(sample, alive);
        pieces.sort_unstable();
        pieces.dedup();
        assert_eq!(parts.len(), pieces.len(), "{name}");
    });
}

#[test]
fn pieces_that_drift_apart_keep_their_shape() {
    for_each_tear(|name, sample, alive, torn| {
        let piece = point_components(sample, alive);
        let drift = |i: usize| Vec3::new(0.0, 0.0, piece[i] as f64);
        let flat = [Vec3::x(), Vec3::y()];
        let (x, gradients) = sample.moved(|i| (flat, drift(i)));
        let places = torn.places(&x, &gradients);
        for t in &torn.surface.triangles {
            let of = |v: u32| drift(torn.ties(v)[0].point as usize).z;
            for v in t {
                assert_eq!(places[*v as usize].z, of(t[0]), "{name}: a triangle spans a gap");
            }
        }
    });
}

/// An edge with one triangle is on the outline, or has its other lip opposite.
#[test]
fn it_is_closed_but_for_outline_and_lips() {
    for_each_tear(|name, sample, alive, torn| {
        let rest = at_rest(sample, torn);
        let edges = directed_edges(torn);
        let at = |v: u32| torn.surface.reference[v as usize].map(f32::to_bits);
        let bare = edges.keys().filter(|[a, b]| !edges.contains_key(&[*b, *a]));
        let bare: Vec<[u32; 2]> = bare.copied().collect();
        let mut lips: BTreeMap<_, u32> = BTreeMap::new();
        let mut length = 0.0;
        for &[a, b] in &bare {
            let (p, q) = (rest[a as usize], rest[b as usize]);
            let on = |side| distance_to(side, p) < 1e-12 && distance_to(side, q) < 1e-12;
            if sides(&sample.outline).any(on) {
                length += (p[0] - q[0]).hypot(p[1] - q[1]);
            } else {
                *lips.entry([at(a), at(b)]).or_default() += 1;
            }
        }
        for (&[from, to], &count) in &lips {
            assert_eq!((count, lips.get(&[to, from])), (1, Some(&1)), "{name}: a lip alone");
        }
        let around = sides(&sample.outline).map(|[a, b]| (a[0] - b[0]).hypot(a[1] - b[1]));
        let around: f64 = around.sum();
        assert!((length / around - 1.0).abs() < 1e-12, "{name}: {length} m around, not {around}");
        assert_eq!(lips.is_empty(), alive.iter().all(|&alive| alive), "{name}");
    });
}

#[test]
fn one_broken_side_is_a_tip_two_are_a_cut_three_a_junction() {
    let sample = Sample::new(rectangle());
    let inner = |&&[a, b, c]: &&[u32; 3]| {
        [a, b, c].iter().all(|&v| {
            let Some(&p) = sample.points.get(v as usize) else { return false };
            sides(&sample.outline).all(|side| distance_to(side, p) > 3.0 * SPACING)
        })
    };
    let &[a, b, c] = sample.mesh.triangles.iter().find(inner).expect("a triangle inside");
    let [ab, bc, ca] = [[a, b], [b, c], [c, a]].map(|[i, j]| [i.min(j), i.max(j)]);
    let pairs = sample.mesh.pairs();
    let whole = sample.mesh.places.len();
    let all = sample.mesh.triangles.len();
    // A triangle becomes four, five or six. Each broken edge has two middles of one point each,
    // and a tip on its other side, of three.
    for (broken, triangles, single, double, triple) in [
        (vec![ab], 3 + 3, 2, 0, 1 + 1),
        (vec![ab, bc], 4 + 3 + 3, 4 + 1, 1, 2),
        (vec![ab, bc, ca], 5 + 3 + 3 + 3, 6 + 3, 0, 3),
    ] {
        let alive: Vec<bool> = pairs.iter().map(|pair| !broken.contains(pair)).collect();
        let torn = TornSurface::new(&sample.mesh, &alive, 0.0);
        let new: Vec<u32> = (whole as u32..torn.surface.reference.len() as u32).collect();
        let count = |n| new.iter().filter(|&&v| torn.ties(v).len() == n).count();
        assert_eq!(torn.surface.triangles.len(), all + triangles);
        assert_eq!([count(1), count(2), count(3)], [single, double, triple]);
        for &tip in new.iter().filter(|&&v| torn.ties(v).len() == 3) {
            let offsets = torn.ties(tip).iter().map(|tie| tie.offset);
            let [x, y] = offsets.fold([0.0; 2], |sum, o| [sum[0] + o[0], sum[1] + o[1]]);
            assert!(x.hypot(y) < 1e-15, "a tip is ({x:e}, {y:e}) m off the middle");
        }
    }
}

#[test]
fn a_crack_is_drawn_smooth() {
    let sample = Sample::new(rectangle());
    let (from, to) = ([0.02, -0.07], [0.36, 0.09]);
    let torn = TornSurface::new(&sample.mesh, &sample.torn_along(&[from, to]), 0.0);
    let rest = at_rest(&sample, &torn);
    let edges = directed_edges(&torn);
    let first = sample.mesh.places.len() as u32;
    let lip = |[a, b]: &&[u32; 2]| *a >= first && *b >= first && !edges.contains_key(&[*b, *a]);
    let lengths = edges.keys().filter(lip).map(|&[a, b]| {
        let (p, q) = (rest[a as usize], rest[b as usize]);
        (p[0] - q[0]).hypot(p[1] - q[1])
    });
    let length = lengths.sum::<f64>() / 2.0;
    let straight = (to[0] - from[0]).hypot(to[1] - from[1]);
    // Without smoothing it is 1.4 times as long.
    assert!((1.0..1.15).contains(&(length / straight)), "{}", length / straight);
}

#[test]
fn quantities_are_those_of_the_points_that_a_vertex_hangs_on() {
    let sample = Sample::new(rectangle());
    let torn = TornSurface::new(&sample.mesh, &sample.torn_at_random(0.05), 0.0);
    let values: Vec<f64> = (0..sample.points.len()).map(|i| i as f64).collect();
    for (v, value) in torn.quantities(&values).into_iter().enumerate() {
        let ties = torn.ties(v as u32);
        let mean = ties.iter().map(|tie| f64::from(tie.point)).sum::<f64>() / ties.len() as f64;
        assert_eq!(value, mean as f32);
        assert!(v >= sample.points.len() || value == v as f32);
    }
}

#[test]
fn nothing_is_drawn_where_there_are_no_points() {
    let outline = rectangle();
    let mut points = scatter(&outline, SPACING);
    points.retain(|&[x, _]| !(0.15..0.25).contains(&x));
    let mesh = SheetTriangulation::new(&points, &outline, SPACING).expect("a sheet");
    let torn = TornSurface::new(&mesh, &vec![true; mesh.pairs().len()], 0.0);
    for t in &torn.surface.triangles {
        for k in 0..3 {
            let [p, q] = [t[k], t[(k + 1) % 3]].map(|v| mesh.places[v as usize]);
            let side = (p[0] - q[0]).hypot(p[1] - q[1]);
            assert!(side <= 2.6 * SPACING, "a side of {side} m");
        }
    }
    // The rim alone goes on.
    let middle = torn
        .surface
        .reference
        .iter()
        .filter(|[x, y]| (0.19..0.21).contains(x) && (-0.06..0.09).contains(y));
    assert_eq!(middle.count(), 0);
    let same = SheetTriangulation::new(&points, &outline, SPACING).expect("a sheet");
    assert_eq!(torn, TornSurface::new(&same, &vec![true; same.pairs().len()], 0.0));
}

#[test]
fn points_on_the_outline_and_at_one_place_do_no_harm() {
    let outline = vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let mut points: Vec<SheetPlace> =
        (0..121).map(|k| [f64::from(k % 11) / 10.0, f64::from(k / 11) / 10.0]).collect();
    points.extend([[0.5, 0.5], [3.0, 3.0]]);
    let mesh = SheetTriangulation::new(&points, &outline, 0.1).expect("a sheet");
    let torn = TornSurface::new(&mesh, &vec![false; mesh.pairs().len()], 0.0);
    let sample = Sample { points, outline, mesh };
    let rest = at_rest(&sample, &torn);
    let areas = torn.surface.triangles.iter().map(|t| t.map(|v| rest[v as usize]));
    let sum: f64 = areas.map(|[a, b, c]| area(a, b, c)).sum();
    assert!((sum - 1.0).abs() < 1e-12, "{sum}");
}

#[test]
fn what_is_no_outline_is_refused() {
    let points = scatter(&rectangle(), SPACING);
    let crossed = [[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]];
    let waist = [[0.0, 0.0], [0.1, 0.0], [0.05, 0.05], [0.1, 0.1], [0.0, 0.1], [0.05, 0.05]];
    let bad: [(&[SheetPlace], f64, &str); 6] = [
        (&waist, 0.01, "meets itself"),
        (&crossed, 0.01, "meets itself"),
        (&crossed[..2], 0.01, "2 corners"),
        (&[[0.0, 0.0], [1.0, f64::NAN], [0.0, 1.0]], 0.01, "side 0 of its outline is NaN m"),
        (&rectangle(), 0.0, "spacing is"),
        (&rectangle(), f64::NAN, "spacing is"),
    ];
    for (outline, spacing, why) in bad {
        let refusal = SheetTriangulation::new(&points, outline, spacing)
            .err()
            .unwrap_or_else(|| panic!("{why}"));
        assert!(refusal.to_string().contains(why), "{refusal}");
    }
    let nowhere = SheetTriangulation::new(&[[f64::INFINITY, 0.0]], &rectangle(), 0.01);
    assert!(nowhere.expect_err("a place").to_string().contains("a place is (inf"));
}
