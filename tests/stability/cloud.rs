//! Points with damage, as a solve leaves them, and what every cut along it keeps.

use cullet_fragment::cut::{CutSettings, DamageField, Partition, extract};
use cullet_geometry::math::unit;
use cullet_geometry::{Solid, Vec3};
use cullet_model::CrackFaceDetail;

pub(crate) const SETTINGS: CutSettings = CutSettings {
    min_volume_ratio: 1e-4,
    max_fragments: 100,
    seed: 1,
    detail: CrackFaceDetail::NONE,
};

/// A cube of edge 1 about the origin.
pub(crate) fn cube() -> Solid {
    Solid::outer(crate::kit::cuboid(Vec3::repeat(1.0)))
}

/// Points, eight to a cell of `h`, with the damage that `damaged` tells.
pub(crate) struct Cloud {
    pub(crate) h: f64,
    pub(crate) positions: Vec<Vec3>,
    damage: Vec<f64>,
    time: Vec<f64>,
    pub(crate) time_step: f64,
}

impl Cloud {
    pub(crate) fn new(
        h: f64,
        (low, high): (Vec3, Vec3),
        inside: impl Fn(Vec3) -> bool,
        damaged: impl Fn(Vec3) -> bool,
    ) -> Self {
        let step = 0.5 * h;
        let n = (high - low).map(|x| (x / step).round() as u64);
        let mut cloud =
            Self { h, positions: vec![], damage: vec![], time: vec![], time_step: 1e-9 };
        for i in 0..n.x * n.y * n.z {
            let node = [i % n.x, i / n.x % n.y, i / (n.x * n.y)];
            let at = |k: usize| {
                low[k] + step * (node[k] as f64 + 0.5 + 0.5 * (unit(5, k as u64, i) - 0.5))
            };
            let p = Vec3::new(at(0), at(1), at(2));
            if inside(p) {
                cloud.positions.push(p);
                cloud.damage.push(if damaged(p) { 1.0 } else { 0.3 * unit(6, 0, i) });
                let time = 1e-6 + 1e-5 * (p.x - low.x);
                cloud.time.push(if damaged(p) { time } else { f64::INFINITY });
            }
        }
        cloud
    }

    /// In [`cube`].
    pub(crate) fn in_cube(h: f64, damaged: impl Fn(Vec3) -> bool) -> Self {
        Self::new(h, (Vec3::repeat(-0.5), Vec3::repeat(0.5)), |_| true, damaged)
    }

    /// Cuts a body along it.
    pub(crate) fn cut_of(&self, solid: &Solid, settings: &CutSettings) -> Partition {
        let field = DamageField {
            spacing: self.h,
            positions: &self.positions,
            damage: &self.damage,
            damage_time: &self.time,
            time_step: self.time_step,
            top_speed: 3000.0,
            scale: Vec3::repeat(1.0),
            normals: None,
            pieces: None,
            scored: &[],
        };
        let partition = extract(solid, &field, settings).expect("a cut");
        is_lawful(&partition, solid.mesh.signed_volume(), self.positions.len());
        partition
    }

    /// Cuts [`cube`] along it.
    pub(crate) fn cut(&self) -> Partition {
        self.cut_of(&cube(), &SETTINGS)
    }
}

/// The laws that every partition keeps: closed parts that add up, each point in one of them.
pub(crate) fn is_lawful(partition: &Partition, whole: f64, points: usize) {
    let sum: f64 = partition.parts.iter().map(|part| part.volume).sum();
    assert!((sum - whole).abs() <= 1e-9 * whole, "parts sum to {sum}, the body is {whole}");
    for part in &partition.parts {
        assert!(part.volume > 0.0 && part.solid.mesh.is_closed());
        assert_eq!(part.solid.surface.len(), part.solid.mesh.triangles.len());
        assert!(!part.hulls.is_empty() && part.hulls.iter().all(|hull| hull.len() >= 4));
    }
    assert!(partition.parts.windows(2).all(|w| w[0].volume >= w[1].volume));
    assert_eq!(partition.particle_part.len(), points);
    assert!(partition.particle_part.iter().all(|&p| (p as usize) < partition.parts.len()));
}

pub(crate) fn volumes(partition: &Partition) -> Vec<f64> {
    partition.parts.iter().map(|part| part.volume).collect()
}
