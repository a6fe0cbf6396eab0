//! Bodies and pieces for the tests: blocks of a grid, bent into shape.
#![allow(dead_code, unreachable_pub)]

use cullet_geometry::math::unit;
use cullet_geometry::{Pose, Quat, Sheet, Solid, TriMesh, Vec3};
use cullet_model::{Fragment, Material, SurfaceLaw};
use cullet_world::{BodyId, BodySpec, ContactMaterial, Hit, World, WorldSettings};
use std::collections::BTreeMap;
use std::sync::Arc;

pub const GLASS: ContactMaterial = ContactMaterial {
    solid: Material {
        density: 2500.0,
        young: 70e9,
        poisson: 0.22,
        failure_stress: 50e6,
        fracture_energy: 8.0,
    },
    restitution: 0.3,
    friction: 0.4,
    surface: SurfaceLaw { hardness: 5.5e9, friction: 0.85 },
    flows: false,
};

pub const STEEL: ContactMaterial = ContactMaterial {
    solid: Material {
        density: 7800.0,
        young: 210e9,
        poisson: 0.3,
        failure_stress: 800e6,
        fracture_energy: 1e5,
    },
    restitution: 0.3,
    friction: 0.4,
    surface: SurfaceLaw { hardness: 2.4e9, friction: 0.85 },
    flows: false,
};

/// The cells of a grid whose points a function bends into space.
pub struct Grid<'a> {
    pub place: &'a dyn Fn([usize; 3]) -> Vec3,
}

impl Grid<'_> {
    /// The closed boundary of the block of cells from `low` up to `high`.
    pub fn mesh(&self, low: [usize; 3], high: [usize; 3]) -> TriMesh {
        let mut mesh = TriMesh::default();
        let mut seen: BTreeMap<[usize; 3], u32> = BTreeMap::new();
        for axis in 0..3 {
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            for side in [low[axis], high[axis]] {
                for i in low[u]..high[u] {
                    for j in low[v]..high[v] {
                        let mut at = |di: usize, dj: usize| {
                            let mut p = [0; 3];
                            (p[axis], p[u], p[v]) = (side, i + di, j + dj);
                            *seen.entry(p).or_insert_with(|| {
                                mesh.vertices.push((self.place)(p));
                                mesh.vertices.len() as u32 - 1
                            })
                        };
                        let [a, b, c, d] = [at(0, 0), at(1, 0), at(1, 1), at(0, 1)];
                        if side == high[axis] {
                            mesh.triangles.extend([[a, b, c], [a, c, d]]);
                        } else {
                            mesh.triangles.extend([[a, c, b], [a, d, c]]);
                        }
                    }
                }
            }
        }
        mesh
    }

    /// One corner set a cell of the block.
    pub fn hulls(&self, low: [usize; 3], high: [usize; 3]) -> Vec<Vec<Vec3>> {
        let mut hulls = Vec::new();
        for i in low[0]..high[0] {
            for j in low[1]..high[1] {
                for k in low[2]..high[2] {
                    let corner =
                        |n: usize| (self.place)([i + (n & 1), j + (n >> 1 & 1), k + (n >> 2)]);
                    hulls.push((0..8).map(corner).collect());
                }
            }
        }
        hulls
    }

    /// A piece that the hit gave nothing.
    pub fn piece(&self, low: [usize; 3], high: [usize; 3]) -> Fragment {
        Fragment {
            solid: Solid::outer(self.mesh(low, high)),
            hulls: self.hulls(low, high),
            velocity: Vec3::zeros(),
            spin: Vec3::zeros(),
            sheet: Sheet::default(),
        }
    }
}

/// A place function for a box of `n` cells a side; inner points move by up to `jitter` of a cell.
pub fn boxed(size: Vec3, n: usize, jitter: f64) -> impl Fn([usize; 3]) -> Vec3 {
    move |p| {
        let key = (p[0] * 1000 + p[1]) as u64 * 1000 + p[2] as u64;
        Vec3::from_fn(|axis, _| {
            let inner = p[axis] > 0 && p[axis] < n;
            let shake = if inner { jitter * (2.0 * unit(9, axis as u64, key) - 1.0) } else { 0.0 };
            ((p[axis] as f64 + shake) / n as f64 - 0.5) * size[axis]
        })
    }
}

/// A box of one cell.
pub fn cuboid(size: Vec3) -> (Solid, Vec<Vec<Vec3>>) {
    let place = boxed(size, 1, 0.0);
    let grid = Grid { place: &place };
    (Solid::outer(grid.mesh([0; 3], [1; 3])), grid.hulls([0; 3], [1; 3]))
}

/// The pieces of a box: all cells of a jittered grid.
pub fn cells(size: Vec3, n: usize, jitter: f64) -> Vec<Fragment> {
    let place = boxed(size, n, jitter);
    let grid = Grid { place: &place };
    let mut pieces = Vec::new();
    for i in 0..n {
        for j in 0..n {
            for k in 0..n {
                pieces.push(grid.piece([i, j, k], [i + 1, j + 1, k + 1]));
            }
        }
    }
    pieces
}

/// A sphere from a cube whose faces are bulged: `n` × `n` cells a face.
pub fn sphere(radius: f64, n: usize) -> (Solid, Vec<Vec<Vec3>>) {
    let place = move |p: [usize; 3]| {
        let q = Vec3::from_fn(|i, _| 2.0 * p[i] as f64 / n as f64 - 1.0);
        // tan spreads the points evenly over the sphere
        let even = q.map(|x| libm::tan(x * std::f64::consts::FRAC_PI_4));
        even.normalize() * radius
    };
    let grid = Grid { place: &place };
    let mesh = grid.mesh([0; 3], [n; 3]);
    let corners = mesh.vertices.clone();
    (Solid::outer(mesh), vec![corners])
}

pub fn settings() -> WorldSettings {
    WorldSettings { impulse_threshold: 1e-6, ..WorldSettings::default() }
}

pub fn weightless() -> WorldSettings {
    WorldSettings { gravity: Vec3::zeros(), ..settings() }
}

pub fn body(
    name: &str,
    (solid, hulls): (Solid, Vec<Vec<Vec3>>),
    material: ContactMaterial,
    at: Vec3,
) -> BodySpec {
    BodySpec {
        density: None,
        name: name.into(),
        solid: Arc::new(solid),
        hulls,
        material,
        pose: Pose::translation(at.x, at.y, at.z),
        velocity: Vec3::zeros(),
        spin: Vec3::zeros(),
        fixed: false,
        driven: None,
        breakable: true,
        weakest: 1.0,
        threshold: None,
        parent: None,
        generation: 0,
        original_volume: None,
    }
}

/// A fixed slab whose top is at z = 0.
pub fn floor() -> BodySpec {
    let slab = cuboid(Vec3::new(20.0, 20.0, 2.0));
    let spec = body("floor", slab, STEEL, Vec3::new(0.0, 0.0, -1.0));
    BodySpec { fixed: true, breakable: false, ..spec }
}

pub fn put(world: &mut World, spec: BodySpec) -> BodyId {
    world.insert(spec).expect("the body is sound")
}

pub fn steps(world: &mut World, n: u32) -> Vec<Hit> {
    (0..n).flat_map(|_| world.step().expect("the step is sound")).collect()
}

/// Steps until something is hit.
pub fn until_hit(world: &mut World, most: u32) -> Vec<Hit> {
    for _ in 0..most {
        let hits = world.step().expect("the step is sound");
        if !hits.is_empty() {
            return hits;
        }
    }
    panic!("nothing was hit in {most} steps");
}

pub fn bits(world: &World) -> Vec<u8> {
    let mut all = Vec::new();
    world.digest(&mut |bytes| all.extend_from_slice(bytes));
    all
}

pub const CUBE: Vec3 = Vec3::new(0.2, 0.2, 0.2);

/// A number in (−1, 1) that belongs to (case, what).
pub fn any(case: u64, what: u64) -> f64 {
    2.0 * unit(77, case, what) - 1.0
}

pub fn any3(case: u64, what: u64) -> Vec3 {
    Vec3::new(any(case, what), any(case, what + 1), any(case, what + 2))
}

/// Gives the pieces a push along `n` that sums up to `impulse`, unevenly, and some spin.
pub fn shove(pieces: &mut [Fragment], case: u64, n: &Vec3, impulse: f64, mass: f64, wild: f64) {
    for (k, piece) in pieces.iter_mut().enumerate() {
        let k = 100 + 10 * k as u64;
        piece.velocity = n * (impulse / mass) + any3(case, k) * wild;
        piece.spin = any3(case, k + 3) * wild * 5.0;
    }
}

/// A glass cube and a steel ball that flies at it, both turning, without gravity.
pub fn approach(case: u64) -> (World, BodyId, BodyId) {
    let mut world = World::new(weightless()).unwrap();
    let turn = Quat::from_scaled_axis(any3(case, 0));
    let at = any3(case, 3) * 3.0;
    let cube = body("cube", cuboid(CUBE), GLASS, Vec3::zeros());
    let cube = BodySpec {
        pose: Pose::from_parts(nalgebra::Translation3::from(at), turn),
        velocity: any3(case, 6),
        spin: any3(case, 9) * 3.0,
        ..cube
    };
    let drift = cube.velocity;
    let cube = put(&mut world, cube);
    let aim = aim(case);
    let ball = body("ball", sphere(0.03, 6), STEEL, at + aim * 0.5);
    let ball = BodySpec {
        velocity: drift - aim * 12.0 + any3(case, 20),
        spin: any3(case, 15) * 9.0,
        ..ball
    };
    let ball = put(&mut world, ball);
    (world, cube, ball)
}

/// The same when the ball has hit the cube, and the hit on the cube.
pub fn strike(case: u64) -> (World, BodyId, BodyId, Vec<Hit>) {
    let (mut world, cube, ball) = approach(case);
    let hits: Vec<Hit> =
        until_hit(&mut world, 60).into_iter().filter(|hit| hit.body == cube).collect();
    assert_eq!(hits.len(), 1);
    (world, cube, ball, hits)
}

/// From the cube of [`approach`] to where the ball comes from.
pub fn aim(case: u64) -> Vec3 {
    Vec3::new(any(case, 12), any(case, 13), 0.3).normalize()
}

/// Gives the pieces of a cube of that side and mass the motion of one body that an impulse moved,
/// in full agreement with where it acts.
pub fn push_at(pieces: &mut [Fragment], side: f64, mass: f64, point: &Vec3, impulse: &Vec3) {
    let spin = point.cross(impulse) / (mass * side * side / 6.0);
    for piece in pieces {
        let centre = piece.solid.mesh.mass_properties().centroid;
        piece.velocity += impulse / mass + spin.cross(&centre);
        piece.spin += spin;
    }
}
