//! What a worker says of a job.

use crate::codec::{self, WireError};
use crate::envelope::{self, Kind};
use crate::mesh::{self, Slabs};
use crate::specimen::SpecimenResult;
use cullet_geometry::{Sheet, Solid, Vec3};
use serde::{Deserialize, Serialize};

/// Most fragments of one body: an order above what a scene may ask for.
pub const MAX_FRAGMENTS: usize = 16_384;
/// Most convex parts of one fragment.
pub const MAX_HULLS: usize = 4_096;
/// Most grains of debris of one body.
pub const MAX_GRAINS: usize = 65_536;
/// Most warnings in a report; further ones are counted in the last.
pub const MAX_WARNINGS: usize = 32;
/// Longest text \[bytes\]; the rest is cut off.
pub const MAX_TEXT: usize = 1_024;
/// Bytes of a grain: position, velocity, volume, size.
const GRAIN: usize = 64;
/// Numbers (u32) and points that describe one fragment ahead of its slabs.
const ROW: usize = 5;

/// The final word on a job.
#[derive(Clone, Debug, PartialEq)]
pub enum Verdict {
    /// It was solved. One fragment means that nothing separated.
    Broken(Box<BrokenBody>),
    /// No family asked took the problem.
    Refused {
        /// The family asked first.
        solver: String,
        /// The bound that the problem breaks.
        text: String,
    },
    /// Numerics went wrong.
    Failed {
        /// The family that failed.
        solver: String,
        /// How.
        text: String,
    },
    /// What came out of a specimen, however it ended.
    Measured(Box<SpecimenResult>),
}

/// A body taken apart.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BrokenBody {
    /// Closed parts.
    pub fragments: Vec<Fragment>,
    /// Of each of them: whether it was sampled, that is drawn from a law, and not solved. Empty in
    /// what an older worker says.
    pub sampled: Vec<bool>,
    /// Parts too small to be fragments.
    pub debris: Vec<Grain>,
    /// Impulse that each support of the job gave \[N·s\]; empty where the method knows none.
    pub reactions: Vec<f64>,
    /// What the solve cost and found out.
    pub report: Report,
}

/// One part of a broken body, in the body's frame before it broke.
#[derive(Clone, Debug, PartialEq)]
pub struct Fragment {
    /// Its closed boundary \[m\].
    pub solid: Solid,
    /// Convex parts that stand in for it in collisions: corner sets \[m\].
    pub hulls: Vec<Vec<Vec3>>,
    /// Velocity of its centroid that the hit gave it \[m/s\].
    pub velocity: Vec3,
    /// Angular velocity that the hit gave it \[rad/s\].
    pub spin: Vec3,
    /// Cracks that end inside it.
    pub sheet: Sheet,
}

/// A point with a mass, in the body's frame before it broke.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grain {
    /// Where \[m\].
    pub position: Vec3,
    /// Velocity that the hit gave it \[m/s\].
    pub velocity: Vec3,
    /// Volume \[m³\].
    pub volume: f64,
    /// Diameter \[m\].
    pub size: f64,
}

/// What a solve cost and what it found out about itself.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// The family that ran.
    pub solver: String,
    /// Why the family asked first did not run, if it refused.
    pub refusal: Option<String>,
    /// Grid spacing h \[m\]; zero where a method has none.
    pub spacing: f64,
    /// Material points; zero where a method has none.
    pub particles: u64,
    /// Time steps taken.
    pub steps: u64,
    /// Simulated time \[s\].
    pub simulated: f64,
    /// Area of the crack between fragments \[m²\].
    pub crack_area: f64,
    /// G_f times `crack_area` \[J\].
    pub fracture_energy: f64,
    /// Energy the damage law dissipated \[J\].
    pub dissipated_energy: f64,
    /// Stress at which cracks grow over σ_f \[1\].
    pub strength_ratio: f64,
    /// Share of particles with damage above one half \[1\].
    pub damaged_fraction: f64,
    /// Impulse that the solve put into the body \[N·s\].
    pub delivered_impulse: f64,
    /// What the detectors noticed and let pass.
    pub warnings: Vec<String>,
}

#[derive(Serialize, Deserialize)]
enum Header {
    Broken { fragments: u32, hulls: u32, grains: u32, reactions: Vec<f64>, report: Report },
    Refused { solver: String, text: String },
    Failed { solver: String, text: String },
}

impl Verdict {
    /// The bytes of the verdict. Texts over [`MAX_TEXT`], warnings over [`MAX_WARNINGS`] are cut.
    ///
    /// # Errors
    /// The limit of the wire that the verdict breaks.
    pub fn encode(&self) -> Result<Vec<u8>, WireError> {
        match self {
            Self::Broken(body) => body.encode(),
            Self::Refused { solver, text } => {
                let (solver, text) = (cut(solver), cut(text));
                envelope::seal(Kind::Verdict, &Header::Refused { solver, text }, &[])
            }
            Self::Failed { solver, text } => {
                let (solver, text) = (cut(solver), cut(text));
                envelope::seal(Kind::Verdict, &Header::Failed { solver, text }, &[])
            }
            Self::Measured(result) => result.encode(),
        }
    }

    /// The verdict in these bytes.
    ///
    /// # Errors
    /// The first thing wrong with them, with the bound.
    pub fn decode(bytes: &[u8]) -> Result<Self, WireError> {
        if envelope::is(Kind::SpecimenResult, bytes) {
            return Ok(Self::Measured(Box::new(SpecimenResult::decode(bytes)?)));
        }
        let (header, slabs) = envelope::open::<Header>(Kind::Verdict, bytes)?;
        let slabs = Slabs::new(slabs);
        match header {
            Header::Broken { fragments, hulls, grains, reactions, report } => {
                let counts = [fragments, hulls, grains];
                let body = BrokenBody::decode(counts, reactions, report, slabs)?;
                Ok(Self::Broken(Box::new(body)))
            }
            Header::Refused { solver, text } => {
                slabs.end("a verdict")?;
                Ok(Self::Refused { solver, text })
            }
            Header::Failed { solver, text } => {
                slabs.end("a verdict")?;
                Ok(Self::Failed { solver, text })
            }
        }
    }
}

impl BrokenBody {
    /// Whether nothing separated.
    #[must_use]
    pub fn is_intact(&self) -> bool {
        self.fragments.len() <= 1 && self.debris.is_empty()
    }

    /// Whether each fragment was sampled; nothing where that is not known. All that the geometric
    /// family makes is.
    #[must_use]
    pub fn sampled(&self) -> Option<Vec<bool>> {
        match (self.sampled.is_empty(), self.report.solver.as_str()) {
            (false, _) => Some(self.sampled.clone()),
            (true, "geometric") => Some(vec![!self.is_intact(); self.fragments.len()]),
            (true, _) => None,
        }
    }

    /// Holds what is beside the fragments to its limits.
    fn check_rest(grains: usize, reactions: &[f64]) -> Result<(), WireError> {
        codec::limit("a body's grains", grains as u64, MAX_GRAINS as u64)?;
        let most = crate::job::MAX_SUPPORTS as u64;
        codec::limit("a body's reactions", reactions.len() as u64, most)?;
        codec::finite("a body's reactions", reactions)
    }

    fn encode(&self) -> Result<Vec<u8>, WireError> {
        let count = self.fragments.len();
        codec::limit("a body's fragments", count as u64, MAX_FRAGMENTS as u64)?;
        let hulls = self.fragments.iter().map(|f| f.hulls.len()).sum::<usize>();
        let report = self.report.cut();
        let (grains, reactions) = (self.debris.len(), self.reactions.clone());
        Self::check_rest(grains, &reactions)?;
        let head = Header::Broken {
            fragments: count as u32,
            hulls: hulls as u32,
            grains: grains as u32,
            reactions,
            report,
        };
        let mut slabs = Vec::new();
        for fragment in &self.fragments {
            let (nv, nt) = mesh::counts(&fragment.solid)?;
            let nh = fragment.hulls.len();
            codec::limit("a fragment's convex parts", nh as u64, MAX_HULLS as u64)?;
            let (sv, st) = mesh::sheet_counts(&fragment.sheet)?;
            mesh::put_u32s(&mut slabs, [nv, nt, sv, st, nh as u32]);
        }
        for hull in self.fragments.iter().flat_map(|f| &f.hulls) {
            let corners = hull.len() as u64;
            codec::limit("a convex part's corners", corners, mesh::MAX_VERTICES)?;
            mesh::put_u32s(&mut slabs, [hull.len() as u32]);
        }
        for fragment in &self.fragments {
            mesh::put_points(&mut slabs, &[fragment.velocity, fragment.spin]);
            mesh::put_solid(&mut slabs, &fragment.solid);
            mesh::put_sheet(&mut slabs, &fragment.sheet);
            fragment.hulls.iter().for_each(|hull| mesh::put_points(&mut slabs, hull));
        }
        for grain in &self.debris {
            mesh::put_points(&mut slabs, &[grain.position, grain.velocity]);
            slabs.extend_from_slice(&grain.volume.to_le_bytes());
            slabs.extend_from_slice(&grain.size.to_le_bytes());
        }
        if !self.sampled.is_empty() {
            let (what, have, need) = ("a body's marks", self.sampled.len(), count);
            if have != need {
                return Err(WireError::Short { what, have, need });
            }
            slabs.extend(self.sampled.iter().map(|&sampled| u8::from(sampled)));
        }
        envelope::seal(Kind::Verdict, &head, &slabs)
    }

    fn decode(
        [fragments, hulls, grains]: [u32; 3],
        reactions: Vec<f64>,
        report: Report,
        mut slabs: Slabs<'_>,
    ) -> Result<Self, WireError> {
        codec::limit("a body's fragments", u64::from(fragments), MAX_FRAGMENTS as u64)?;
        Self::check_rest(grains as usize, &reactions)?;
        report.check()?;
        let rows = slabs.u32s("a body's fragments", ROW * fragments as usize)?;
        let rows = rows.as_chunks::<ROW>().0;
        let announced = rows.iter().map(|[.., nh]| u64::from(*nh)).sum::<u64>();
        if announced != u64::from(hulls) {
            let (have, need) = (hulls as usize, announced as usize);
            return Err(WireError::Short { what: "a body's convex parts", have, need });
        }
        let sizes = slabs.u32s("a body's convex parts", hulls as usize)?;
        let mut sizes = sizes.into_iter();
        let fragments = rows.iter().map(|[nv, nt, sv, st, nh]| {
            codec::limit("a fragment's convex parts", u64::from(*nh), MAX_HULLS as u64)?;
            let motion = slabs.points("a fragment's motion", 2)?;
            let solid = slabs.solid(*nv, *nt)?;
            let sheet = slabs.sheet(*sv, *st)?;
            let sizes = sizes.by_ref().take(*nh as usize);
            let hulls = sizes.map(|n| slabs.points("a convex part's corners", n as usize));
            let hulls = hulls.collect::<Result<_, _>>()?;
            Ok(Fragment { solid, hulls, velocity: motion[0], spin: motion[1], sheet })
        });
        let fragments = fragments.collect::<Result<Vec<_>, WireError>>()?;
        let bytes = slabs.take("a body's grains", grains as usize, GRAIN)?;
        let debris = bytes.as_chunks::<GRAIN>().0.iter().map(Grain::from_row);
        let debris = debris.collect::<Result<_, _>>()?;
        let sampled = match slabs.is_empty() {
            true => Vec::new(),
            false => marks(slabs.take("a body's marks", fragments.len(), 1)?)?,
        };
        slabs.end("a verdict")?;
        Ok(Self { fragments, sampled, debris, reactions, report })
    }
}

/// Bytes of which each says yes or no.
fn marks(bytes: &[u8]) -> Result<Vec<bool>, WireError> {
    let most = bytes.iter().copied().max().unwrap_or(0);
    codec::limit("a mark of a fragment", u64::from(most), 1)?;
    Ok(bytes.iter().map(|&mark| mark == 1).collect())
}

impl Grain {
    fn from_row(row: &[u8; GRAIN]) -> Result<Self, WireError> {
        let number = |k: usize| f64::from_le_bytes(row.as_chunks::<8>().0[k]);
        let numbers: [f64; 8] = std::array::from_fn(number);
        codec::finite("a body's grains", &numbers)?;
        let [x, y, z, u, v, w, volume, size] = numbers;
        let (position, velocity) = (Vec3::new(x, y, z), Vec3::new(u, v, w));
        Ok(Self { position, velocity, volume, size })
    }
}

impl Report {
    fn check(&self) -> Result<(), WireError> {
        let numbers = [
            self.spacing,
            self.simulated,
            self.crack_area,
            self.fracture_energy,
            self.dissipated_energy,
            self.strength_ratio,
            self.damaged_fraction,
            self.delivered_impulse,
        ];
        codec::finite("a report's numbers", &numbers)?;
        let warnings = self.warnings.len() as u64;
        codec::limit("a report's warnings", warnings, MAX_WARNINGS as u64)
    }

    fn cut(&self) -> Self {
        let mut warnings: Vec<_> =
            self.warnings.iter().take(MAX_WARNINGS).map(|w| cut(w)).collect();
        let more = self.warnings.len().saturating_sub(MAX_WARNINGS);
        if let Some(last) = warnings.last_mut().filter(|_| more > 0) {
            *last = format!("{} more warnings", more + 1);
        }
        let refusal = self.refusal.as_deref().map(cut);
        Self { solver: cut(&self.solver), refusal, warnings, ..self.clone() }
    }
}

/// The text, up to [`MAX_TEXT`] bytes of it.
#[must_use]
pub fn cut(text: &str) -> String {
    text[..text.floor_char_boundary(MAX_TEXT)].to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::FractureJob;
    use crate::job::tests::{sample as job, tetrahedron};
    use cullet_geometry::TriMesh;
    use cullet_geometry::math::unit;

    fn fin() -> Sheet {
        let mesh = TriMesh {
            vertices: vec![Vec3::zeros(), Vec3::x(), Vec3::y()],
            triangles: vec![[0, 1, 2]],
        };
        Sheet { mesh, damage_time: vec![1e-5, 2e-5, 0.0], front_speed: vec![0.0, 9.0, 8.0] }
    }

    fn sample() -> Verdict {
        let fragment = |k: usize| Fragment {
            solid: tetrahedron(),
            hulls: (0..k).map(|h| vec![Vec3::repeat(h as f64); 4 + h]).collect(),
            velocity: Vec3::new(k as f64, 0.0, -1.0),
            spin: Vec3::y(),
            sheet: if k == 1 { fin() } else { Sheet::default() },
        };
        let report = Report {
            solver: "geometric".into(),
            refusal: Some("too thin".into()),
            warnings: vec!["a word".into()],
            strength_ratio: 1.0,
            ..Report::default()
        };
        let fragments = vec![fragment(1), fragment(0), fragment(3)];
        let grain = Grain { position: Vec3::x(), velocity: Vec3::y(), volume: 1e-9, size: 1e-3 };
        let debris = vec![grain, Grain { size: 2e-3, ..grain }];
        let reactions = vec![0.5, 0.0];
        let sampled = vec![true, false, true];
        Verdict::Broken(Box::new(BrokenBody { fragments, sampled, debris, reactions, report }))
    }

    #[test]
    fn verdicts_come_back() -> Result<(), WireError> {
        let (solver, text) = ("brittle".to_owned(), "too thin".to_owned());
        let refused = Verdict::Refused { solver: solver.clone(), text: text.clone() };
        let failed = Verdict::Failed { solver, text };
        for verdict in [sample(), refused, failed] {
            assert_eq!(Verdict::decode(&verdict.encode()?)?, verdict);
        }
        Ok(())
    }

    /// What workers of before say, and caches hold.
    #[test]
    fn a_verdict_without_marks_of_what_was_sampled_is_read() -> Result<(), WireError> {
        let Verdict::Broken(mut body) = sample() else { panic!("another verdict") };
        let marked = Verdict::Broken(body.clone()).encode()?;
        assert_eq!(body.sampled(), Some(vec![true, false, true]));
        body.sampled.clear();
        let plain = Verdict::Broken(body.clone()).encode()?;
        assert_eq!(plain.len() + 3, marked.len());
        assert_eq!(Verdict::decode(&plain)?, Verdict::Broken(body.clone()));
        assert_eq!(body.sampled(), Some(vec![true; 3]), "the geometric family draws all");
        body.report.solver = "brittle".into();
        assert_eq!(body.sampled(), None, "that is not known");
        body.sampled = vec![true];
        assert!(Verdict::Broken(body).encode().is_err(), "a mark for each or none");
        Ok(())
    }

    #[test]
    fn long_words_are_cut_between_letters() -> Result<(), WireError> {
        let text = "ä".repeat(MAX_TEXT);
        let long = Verdict::Failed { solver: "x".into(), text };
        let Verdict::Failed { text, .. } = Verdict::decode(&long.encode()?)? else {
            panic!("another verdict");
        };
        assert_eq!(text, "ä".repeat(MAX_TEXT / 2));
        Ok(())
    }

    #[test]
    fn counts_that_promise_too_much_allocate_nothing() -> Result<(), WireError> {
        let header = |fragments, grains| Header::Broken {
            fragments,
            hulls: 0,
            grains,
            reactions: Vec::new(),
            report: Report::default(),
        };
        let head = header(16_000, 0);
        let bytes = envelope::seal(Kind::Verdict, &head, &[1, 2, 3])?;
        assert!(matches!(Verdict::decode(&bytes), Err(WireError::Short { have: 3, .. })));
        for head in [header(u32::MAX, 0), header(0, u32::MAX)] {
            let bytes = envelope::seal(Kind::Verdict, &head, &[])?;
            assert!(matches!(Verdict::decode(&bytes), Err(WireError::Limit { .. })));
        }
        let bytes = envelope::seal(Kind::Verdict, &header(0, 2), &[0; 64])?;
        assert!(matches!(
            Verdict::decode(&bytes),
            Err(WireError::Short { have: 64, need: 128, .. })
        ));
        Ok(())
    }

    /// A changed header is given a right checksum again, so that the damage gets past it.
    fn damaged(good: &[u8], round: u64) -> Vec<u8> {
        let mut bad = good.to_vec();
        let draw = |k: u64, n: usize| (unit(round, k, 9) * n as f64) as usize;
        for change in 0..1 + draw(0, 4) as u64 {
            let at = draw(3 * change + 1, bad.len());
            bad[at] = match draw(3 * change + 2, 4) {
                0 => 0,
                1 => 0xff,
                2 => bad[at] ^ (1 << draw(3 * change + 3, 8)),
                _ => draw(3 * change + 3, 256) as u8,
            };
        }
        if draw(99, 5) == 0 {
            bad.truncate(draw(98, bad.len()));
        }
        if bad.len() > envelope::PREFIX && draw(97, 2) == 0 {
            bad[..12].copy_from_slice(&good[..12]);
            let length = u32::from_le_bytes([bad[12], bad[13], bad[14], bad[15]]) as usize;
            let end = bad.len().min(envelope::PREFIX + length);
            let sum = crc32c::crc32c(&bad[envelope::PREFIX..end]);
            bad[16..20].copy_from_slice(&sum.to_le_bytes());
        }
        bad
    }

    #[test]
    fn damaged_bytes_never_panic_and_what_passes_is_sound() -> Result<(), WireError> {
        let (verdict, job) = (sample().encode()?, job().encode()?);
        let mut passed = 0;
        for round in 0..60_000 {
            if let Ok(Verdict::Broken(body)) = Verdict::decode(&damaged(&verdict, round)) {
                passed += 1;
                for fragment in &body.fragments {
                    let n = fragment.solid.mesh.vertices.len() as u32;
                    assert!(fragment.solid.mesh.triangles.iter().flatten().all(|i| *i < n));
                    assert!(fragment.velocity.iter().all(|x| x.is_finite()));
                    assert_eq!(fragment.sheet.validate(), Ok(()));
                }
                assert!(body.debris.iter().all(|grain| grain.volume.is_finite()));
            }
            if let Ok(job) = FractureJob::decode(&damaged(&job, round)) {
                assert!(job.material.young.is_finite() && !job.impacts.is_empty());
            }
        }
        assert!(passed > 100, "only {passed} got past the checksum");
        Ok(())
    }
}
