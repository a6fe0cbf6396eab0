//! What is read off a plate: its points at the stations through the thickness.

use super::build::PlateDomain;
use crate::kernel::SurfaceStrain;
use crate::midsurface::MidsurfacePoint;
use cullet_geometry::symmetric::Sym3;
use cullet_geometry::{Mat3, Vec3};
use cullet_simd::Real;
use cullet_specimen::{FieldValues, LocalVector, PointField, PointFields};

/// Points of a part below which it is no piece (F99).
const LEAST_PART: usize = 8;

/// The points that are read, as they were before anything moved.
#[derive(Clone, Debug)]
pub(super) struct ReadPoints {
    /// Points that are on.
    live: Vec<usize>,
    surfaces: Vec<MidsurfacePoint>,
    /// Place over t and weight of each station.
    stations: Vec<(f64, f64)>,
}

/// A vector of a midsurface point, with that of its normal.
struct NormalMotion {
    middle: Vec3,
    normal: Vec3,
    /// Derivatives of both along the axes of the plane \[1/m\].
    slopes: [(Vec3, Vec3); 2],
}

impl ReadPoints {
    pub(super) fn new<R: Real>(domain: &PlateDomain<R>) -> Self {
        let live: Vec<usize> = domain.live().collect();
        let surfaces = live.iter().map(|&p| domain.surface.surface_point(p)).collect();
        Self { live, surfaces, stations: domain.law.stations.list().to_vec() }
    }

    /// How many there are.
    pub(super) fn len(&self) -> usize {
        self.live.len() * self.stations.len()
    }

    /// What the points carry, station by station of one after the other.
    pub(super) fn fields<R: Real>(
        &self,
        domain: &PlateDomain<R>,
        fields: &[PointField],
    ) -> PointFields {
        let each = |of: &dyn Fn(usize, f64, f64) -> Vec3| -> Vec<Vec3> {
            let rows = (0..self.live.len()).flat_map(|k| self.stations.iter().map(move |s| (k, s)));
            rows.map(|(k, &(z, w))| of(k, z, w)).collect()
        };
        let thickness = |k: usize| domain.state(self.live[k]).thickness;
        let places = each(&|k, z, _| {
            let surface = &self.surfaces[k];
            surface.place + surface.normal * (z * thickness(k))
        });
        let volume = |k: usize, w: f64| domain.state(self.live[k]).area * thickness(k) * w;
        let volumes = each(&|k, _, w| Vec3::repeat(volume(k, w)));
        let is_strained = |f: &PointField| matches!(f, PointField::Stress | PointField::Strain);
        let strains = if fields.iter().any(is_strained) { domain.strains() } else { Vec::new() };
        let value = |field| self.field(domain, field, &strains);
        PointFields {
            numbers: (0..places.len() as u32).collect(),
            places,
            volumes: volumes.into_iter().map(|v| v.x).collect(),
            fields: fields.iter().map(|&field| (field, value(field))).collect(),
        }
    }

    fn field<R: Real>(
        &self,
        domain: &PlateDomain<R>,
        field: PointField,
        strains: &[SurfaceStrain],
    ) -> FieldValues {
        let points = 0..self.live.len();
        match field {
            // No specimen of a shell yields.
            PointField::PlasticStrain | PointField::VolumeRatio => {
                FieldValues::Numbers(vec![f64::NAN; self.live.len() * self.stations.len()])
            }
            PointField::Damage => {
                let of = |k: usize| {
                    let state = domain.state(self.live[k]);
                    let damage = if state.dead { 1.0 } else { state.damage };
                    vec![damage; self.stations.len()]
                };
                FieldValues::Numbers(points.flat_map(of).collect())
            }
            PointField::Displacement | PointField::Velocity => {
                let of = |k: usize| self.vectors(domain, k, field == PointField::Velocity);
                FieldValues::Vectors(points.flat_map(of).collect())
            }
            PointField::Stress | PointField::Strain => {
                let of =
                    |k: usize| self.tensors(domain, k, &strains[k], field == PointField::Stress);
                FieldValues::Tensors(points.flat_map(of).collect())
            }
        }
    }

    /// Displacement u + z(a₃ − A₃), or its rate, at the stations of a point.
    fn vectors<R: Real>(&self, domain: &PlateDomain<R>, k: usize, rate: bool) -> Vec<LocalVector> {
        let motion = self.motion(domain, k, rate);
        let (surface, t) = (&self.surfaces[k], domain.state(self.live[k]).thickness);
        let [e1, e2] = surface.frame();
        let at = |&(z, _): &(f64, f64)| {
            let slopes = [0, 1].map(|d| {
                let (middle, normal) = motion.slopes[d];
                middle + normal * (z * t)
            });
            let axes = Mat3::from_columns(&[e1, e2, surface.normal]);
            let gradient = Mat3::from_columns(&[slopes[0], slopes[1], motion.normal]);
            LocalVector {
                value: motion.middle + motion.normal * (z * t),
                gradient: gradient * axes.transpose(),
            }
        };
        self.stations.iter().map(at).collect()
    }

    /// Of a flat plate: A₃ has no derivatives.
    fn motion<R: Real>(&self, domain: &PlateDomain<R>, k: usize, rate: bool) -> NormalMotion {
        let (point, surface) = (self.live[k], &self.surfaces[k]);
        let (nodes, _) = domain.functions(point);
        let (_, table) = domain.surface.at(point);
        let sum = |row: &[f64], of: &dyn Fn(usize) -> Vec3| -> Vec3 {
            nodes.iter().zip(row).map(|(&n, share)| of(n as usize) * *share).sum()
        };
        let moved = |n: usize| domain.moved(n);
        let speed = |n: usize| domain.velocity[n];
        let first = |of: &dyn Fn(usize) -> Vec3| {
            let d = [0, 1].map(|d| sum(&table.derivatives[d], of));
            self.local(k, d)
        };
        let [e1, e2] = surface.frame();
        let u = first(&moved);
        let now = [e1 + u[0], e2 + u[1]];
        let across = now[0].cross(&now[1]);
        let normal = across.normalize();
        // δa₃ = (1 − a₃a₃ᵀ)(δa₁ × a₂ + a₁ × δa₂)/j.
        let turned = |d: [Vec3; 2]| {
            let w = d[0].cross(&now[1]) + now[0].cross(&d[1]);
            (w - normal * normal.dot(&w)) / across.norm()
        };
        let second = |of: &dyn Fn(usize) -> Vec3| {
            let [d11, d22, d12] = [2, 3, 4].map(|d| sum(&table.derivatives[d], of));
            let [by1, by2] = [[d11, d12], [d12, d22]].map(|d| self.local(k, d));
            let along = |m: usize| self.local(k, [by1[m], by2[m]]);
            let (first, second) = (along(0), along(1));
            [[first[0], second[0]], [first[1], second[1]]].map(turned)
        };
        if rate {
            let v = first(&speed);
            let bends = second(&speed);
            let slopes = [0, 1].map(|d| (v[d], bends[d]));
            return NormalMotion { middle: sum(&table.value, &speed), normal: turned(v), slopes };
        }
        let bends = second(&moved);
        let slopes = [0, 1].map(|d| (u[d], bends[d]));
        let middle = sum(&table.value, &moved);
        NormalMotion { middle, normal: normal - surface.normal, slopes }
    }

    /// Derivatives by the parameters as derivatives along e₁ and e₂.
    fn local(&self, k: usize, [d1, d2]: [Vec3; 2]) -> [Vec3; 2] {
        let [t11, t12, t22] = self.surfaces[k].to_local;
        [d1 * t11, d1 * t12 + d2 * t22]
    }

    /// Strain, or the stress that is left of it, at the stations of a point. The strain through
    /// the thickness is that of no stress through it.
    fn tensors<R: Real>(
        &self,
        domain: &PlateDomain<R>,
        k: usize,
        strain: &SurfaceStrain,
        is_stress: bool,
    ) -> Vec<Sym3> {
        let state = domain.state(self.live[k]);
        let [e1, e2] = self.surfaces[k].frame();
        let normal = self.surfaces[k].normal;
        let ratio = domain.law.elastic.poisson / (1.0 - domain.law.elastic.poisson);
        let at = |&(z, _): &(f64, f64)| {
            let own = strain.at(z * state.thickness);
            let even = SurfaceStrain { membrane: own, bending: [0.0; 3] };
            let ([a, b, c], up) = if is_stress {
                (domain.law.borne(state, &even).force.map(|n| n / state.thickness), 0.0)
            } else {
                (own, -ratio * (own[0] + own[1]))
            };
            let m = e1 * e1.transpose() * a
                + e2 * e2.transpose() * b
                + (e1 * e2.transpose() + e2 * e1.transpose()) * c
                + normal * normal.transpose() * up;
            [m[(0, 0)], m[(1, 1)], m[(2, 2)], m[(0, 1)], m[(1, 2)], m[(2, 0)]]
        };
        self.stations.iter().map(at).collect()
    }

    /// Shares of the plate's mass that its pieces have, by their whole points, the largest first.
    pub(super) fn shares<R: Real>(&self, domain: &PlateDomain<R>) -> Vec<f64> {
        let parts = domain.parts(LEAST_PART);
        let count = parts.iter().flatten().max().map_or(0, |most| *most as usize + 1);
        let mut shares = vec![0.0; count];
        let mut whole = 0.0;
        for &point in &self.live {
            let area = domain.state(point).area;
            whole += area;
            if let Some(part) = parts[point] {
                shares[part as usize] += area;
            }
        }
        shares.iter_mut().for_each(|share| *share /= whole);
        shares.sort_unstable_by(|a, b| b.total_cmp(a));
        shares
    }
}
