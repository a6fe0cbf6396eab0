//! The cube with an edge crack of the thesis's Fig. 3.14 and 3.17 to 3.19, and what is measured.

use cullet_fracture::damage::{DamageState, Softening};
use cullet_fracture::mpm::domain::{PointMotion, PrescribedVelocity, VelocityFields};
use cullet_fracture::mpm::elastic::green_strain;
use cullet_fracture::mpm::symmetric::Sym3;
use cullet_fracture::mpm::{Domain, quadrature};
use cullet_fracture::particles::Particles;
use cullet_geometry::{Quat, TriMesh, Vec3, inside::Inside, sample, shapes};
use cullet_model::Material;
use std::sync::Arc;

pub(crate) const STONE: Material = Material {
    density: 2450.0,
    young: 32e9,
    poisson: 0.2,
    failure_stress: 3e6,
    fracture_energy: 3.0,
};
/// Grid spacing \[m\].
pub(crate) const H: f64 = 0.005;

/// How points are laid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Points {
    /// As the solver lays them.
    Poisson(u64),
    /// Two along each edge of a cell, in the grid's directions.
    Lattice,
}

impl Points {
    /// Two along each edge of a cell, up to `reach` from the middle along each axis.
    pub(crate) fn lattice(inside: &Inside, reach: i32) -> Vec<Vec3> {
        let line = move || -reach..reach;
        let places = line().flat_map(|i| line().flat_map(move |j| line().map(move |k| [i, j, k])));
        let place = places.map(|at| Vec3::from(at.map(|a| (f64::from(a) + 0.5) * 0.5 * H)));
        place.filter(|x| inside.contains(*x)).collect()
    }
}

/// A block whose crack lies in y = 0 for x < 0, its front along z, in a frame of its own.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Specimen {
    /// Half the edges, in spacings.
    pub(crate) half: Vec3,
    /// From the block's directions to the grid's.
    pub(crate) turn: Quat,
    /// Where the block's middle is on the grid, in spacings.
    pub(crate) middle: Vec3,
    pub(crate) points: Points,
}

impl Specimen {
    /// A cube along the grid.
    pub(crate) fn straight(half: f64, seed: u64) -> Self {
        let points = Points::Poisson(seed);
        Self { half: Vec3::repeat(half), turn: Quat::identity(), middle: Vec3::zeros(), points }
    }

    /// A place on the grid \[m\], as the block sees it, in spacings.
    pub(crate) fn local(&self, x: &Vec3) -> Vec3 {
        self.turn.inverse_transform_vector(&(x / H - self.middle))
    }

    fn mesh(&self) -> TriMesh {
        let edges = self.half * (2.0 * H);
        let mut mesh = shapes::cuboid(edges, shapes::Detail::default()).expect("a box");
        mesh.vertices.iter_mut().for_each(|x| *x = self.turn * *x + self.middle * H);
        mesh
    }

    fn sample(&self, inside: &Inside) -> Vec<Vec3> {
        match self.points {
            Points::Poisson(seed) => sample::poisson(inside, 0.5 * H, seed).expect("points"),
            Points::Lattice => Points::lattice(inside, (4.0 * self.half.max()) as i32 + 4),
        }
    }

    /// Its points; those near the grips do not break.
    pub(crate) fn particles(&self) -> Particles {
        let mesh = self.mesh();
        let inside = Inside::new(&mesh);
        let (points, volume) = (self.sample(&inside), mesh.signed_volume());
        let mut particles = Particles::at_rest(&points, volume, STONE.density);
        particles.volume = quadrature::volumes(&points, &inside, Vec3::repeat(H), volume);
        for (strength, x) in particles.strength.iter_mut().zip(&points) {
            *strength = if self.local(x).y.abs() > 0.7 * self.half.y { 100.0 } else { 1.0 };
        }
        particles
    }

    pub(crate) fn law() -> Softening {
        Softening::on_grid(&STONE, H)
    }

    /// Velocity of the upper grip `way` \[m/s\], in the block's directions, and against it below;
    /// between them it rises evenly at first.
    pub(crate) fn launch(&self, way: Vec3) -> impl Fn(&Vec3) -> Vec3 + use<> {
        let own = *self;
        move |x| own.turn * way * (own.local(x).y / own.half.y).clamp(-1.0, 1.0)
    }

    pub(crate) fn grip(&self, way: Vec3) -> PrescribedVelocity {
        let own = *self;
        PrescribedVelocity(Arc::new(move |x| {
            let y = own.local(&x).y;
            (y.abs() > 0.8 * own.half.y).then(|| own.turn * way * y.signum())
        }))
    }

    /// The solver's domain, cracked and already moving as it will.
    pub(crate) fn domain(&self, way: Vec3, fields: VelocityFields) -> Domain {
        let mut domain = Domain::new(self.particles(), &STONE, Self::law(), Vec3::repeat(H));
        domain.sever(|a, b| {
            let (a, b) = (self.local(a), self.local(b));
            let at = a.x + (b.x - a.x) * a.y / (a.y - b.y);
            a.y > 0.0 && b.y < 0.0 && at < 0.0
        });
        domain.fields = fields;
        domain.launch(self.launch(way));
        domain.prescribed = Some(self.grip(way));
        domain
    }

    /// The same without a crack; nothing breaks.
    pub(crate) fn unbroken(&self, way: Vec3) -> Domain {
        let mut particles = self.particles();
        particles.strength.fill(1e6);
        let mut domain = Domain::new(particles, &STONE, Self::law(), Vec3::repeat(H));
        domain.launch(self.launch(way));
        domain.prescribed = Some(self.grip(way));
        domain
    }

    /// Section ahead of the front \[m²\].
    pub(crate) fn section(&self) -> f64 {
        2.0 * self.half.x * self.half.z * H * H
    }

    /// Places of the broken points, as the block sees them, in spacings.
    pub(crate) fn broken(&self, particles: &Particles) -> Vec<Vec3> {
        let pairs = particles.reference.iter().zip(&particles.damage);
        pairs.filter(|(_, damage)| **damage >= 1.0).map(|(x, _)| self.local(x)).collect()
    }

    /// Layers of broken points, half a spacing each, across the section ahead of the front.
    pub(crate) fn layers(&self, broken: &[Vec3]) -> f64 {
        let ahead = broken.iter().filter(|x| x.x > 1.0).count() as f64;
        ahead / (4.0 * 2.0 * self.half.z * (self.half.x - 1.0))
    }

    /// Whether a point broke in every column, a spacing wide, of the section ahead of the front.
    pub(crate) fn is_cut(&self, broken: &[Vec3]) -> bool {
        let (wide, long) = (self.half.x as usize, 2 * self.half.z as usize);
        let mut columns = vec![false; wide * long];
        for x in broken.iter().filter(|x| x.x >= 0.0) {
            let (i, k) = (x.x as usize, (x.z + self.half.z) as usize);
            columns[i.min(wide - 1) * long + k.min(long - 1)] = true;
        }
        columns.iter().all(|&cut| cut)
    }
}

/// Pieces of more than a tenth of the body.
pub(crate) fn pieces(domain: &Domain) -> usize {
    let pieces = domain.pieces();
    let mut sizes = std::collections::BTreeMap::new();
    for piece in pieces.iter().flatten() {
        *sizes.entry(*piece).or_insert(0) += 1;
    }
    sizes.values().filter(|&&size| size > pieces.len() / 10).count()
}

/// What points bear and hold.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Now {
    /// Elastic energy \[J\].
    pub(crate) elastic: f64,
    /// Kinetic energy \[J\].
    pub(crate) kinetic: f64,
    /// Mean pull along y between crack and grips \[Pa\].
    pub(crate) pull: f64,
}

/// Second Piola–Kirchhoff stress of a point as it is weakened now \[Pa\].
fn stress(law: &Softening, motion: &PointMotion, particles: &Particles, p: usize) -> Sym3 {
    let damage = if particles.eroded[p] { 1.0 } else { particles.damage[p] };
    let state = DamageState { damage, strength: 1e12, shielded: false, lone: 1.0 };
    law.respond(&green_strain(&motion.displacement_gradient), state).stress
}

impl Specimen {
    /// Energies and the pull, from the points alone: the same for every method.
    pub(crate) fn now(&self, particles: &Particles, motions: &[PointMotion]) -> Now {
        let (law, mut found, mut volume) = (Self::law(), Now::default(), 0.0);
        let across = self.turn * Vec3::y();
        for (p, motion) in motions.iter().enumerate() {
            let (own, mass) = (particles.volume[p], particles.mass(p));
            let s = stress(&law, motion, particles, p);
            let e = green_strain(&motion.displacement_gradient);
            let work = |i: usize| s[i] * e[i] + 2.0 * s[i + 3] * e[i + 3];
            found.elastic += 0.5 * own * (work(0) + work(1) + work(2));
            // A point is a cloud of second moment h²/4 along each axis.
            let own_spin = 0.25 * H * H * motion.velocity_gradient.norm_squared();
            found.kinetic += 0.5 * mass * (motion.velocity.norm_squared() + own_spin);
            let y = self.local(&particles.reference[p]).y.abs();
            if y > 2.5 && y < 0.7 * self.half.y {
                let pulled = cullet_fracture::mpm::elastic::matrix(&s) * across;
                found.pull += own * pulled.dot(&across);
                volume += own;
            }
        }
        found.pull /= volume;
        found
    }
}
