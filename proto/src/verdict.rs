//! What a worker says of a job.

use crate::bounds::MAX_SUPPORTS;
use crate::codec::{self, WireError};
use crate::envelope::{self, MessageKind};
use crate::mesh::{self, Slabs};
use crate::specimen::SpecimenResult;
use crate::window;
use cullet_geometry::Vec3;
use cullet_model::outcome::{DAMAGED_FRACTION, DELIVERED_IMPULSE, STRENGTH_RATIO};
use cullet_model::{
    BodyShape, Deformation, Figure, Fragment, FragmentOrigin, Fragmentation, Grain, Report,
    SolveOutcome, WindowOutcome,
};
use serde::{Deserialize, Serialize};

pub use crate::bounds::{
    MAX_DETAILS, MAX_FRAGMENTS, MAX_GRAINS, MAX_HULLS, MAX_TEXT, MAX_WARNINGS, cut,
};

/// Longest name or unit of a figure \[bytes\].
const MAX_NAME: usize = 64;
/// Bytes of a grain: position, velocity, volume, size.
const GRAIN: usize = 64;
/// Numbers (u32) and points that describe one fragment ahead of its slabs.
const ROW: usize = 5;

/// The final word on a job.
#[derive(Clone, Debug, PartialEq)]
pub enum Verdict {
    /// It was solved.
    Solved(SolveOutcome),
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
        /// The reason, in words.
        text: String,
    },
    /// What came out of a specimen, however it ended.
    Measured(Box<SpecimenResult>),
    /// What came of a window of a body that moves as it deforms.
    Moved(Box<WindowOutcome>),
}

impl From<Fragmentation> for Verdict {
    fn from(fracture: Fragmentation) -> Self {
        Self::Solved(fracture.into())
    }
}

/// A report as version 0.1 wrote it.
#[derive(Default, Serialize, Deserialize)]
struct OldReport {
    solver: String,
    refusal: Option<String>,
    spacing: f64,
    particles: u64,
    steps: u64,
    simulated: f64,
    crack_area: f64,
    fracture_energy: f64,
    dissipated_energy: f64,
    strength_ratio: f64,
    damaged_fraction: f64,
    delivered_impulse: f64,
    warnings: Vec<String>,
}

impl OldReport {
    fn report(self) -> Report {
        Report {
            solver: self.solver,
            refusal: self.refusal,
            spacing: self.spacing,
            particles: self.particles,
            steps: self.steps,
            simulated: self.simulated,
            crack_area: self.crack_area,
            fracture_energy: self.fracture_energy,
            dissipated_energy: self.dissipated_energy,
            details: Vec::new(),
            warnings: self.warnings,
        }
        .with(STRENGTH_RATIO, "1", self.strength_ratio)
        .with(DAMAGED_FRACTION, "1", self.damaged_fraction)
        .with(DELIVERED_IMPULSE, "N·s", self.delivered_impulse)
    }
}

/// The numbers ahead of a body in parts.
#[derive(Clone, Copy, Serialize, Deserialize)]
struct PartCounts {
    fragments: u32,
    hulls: u32,
    grains: u32,
}

/// Variants are distinguished by their place: new ones go to the end.
#[derive(Serialize, Deserialize)]
enum VerdictHeader {
    /// As version 0.1 wrote it; caches hold such.
    Old {
        counts: PartCounts,
        reactions: Vec<f64>,
        report: OldReport,
    },
    Refused {
        solver: String,
        text: String,
    },
    Failed {
        solver: String,
        text: String,
    },
    Parts {
        counts: PartCounts,
        reactions: Vec<f64>,
        report: Report,
    },
    Deformed(DeformedHeader),
}

/// A body of a new shape, ahead of its mesh.
#[derive(Serialize, Deserialize)]
struct DeformedHeader {
    vertices: u32,
    triangles: u32,
    hulls: u32,
    velocity: [f64; 3],
    spin: [f64; 3],
    work: f64,
    reactions: Vec<f64>,
    report: Report,
}

impl Verdict {
    /// The bytes of the verdict. Texts over [`MAX_TEXT`], warnings over [`MAX_WARNINGS`] are cut.
    ///
    /// # Errors
    /// The limit of the wire that the verdict breaks.
    pub fn encode(&self) -> Result<Vec<u8>, WireError> {
        match self {
            Self::Solved(SolveOutcome::Broken(fracture) | SolveOutcome::Unchanged(fracture)) => {
                encode_parts(fracture)
            }
            Self::Solved(SolveOutcome::Deformed(deformation)) => encode_deformed(deformation),
            Self::Refused { solver, text } => {
                let (solver, text) = (cut(solver), cut(text));
                envelope::seal(MessageKind::Verdict, &VerdictHeader::Refused { solver, text }, &[])
            }
            Self::Failed { solver, text } => {
                let (solver, text) = (cut(solver), cut(text));
                envelope::seal(MessageKind::Verdict, &VerdictHeader::Failed { solver, text }, &[])
            }
            Self::Measured(result) => result.encode(),
            Self::Moved(outcome) => window::encode_outcome(outcome),
        }
    }

    /// The verdict in these bytes.
    ///
    /// # Errors
    /// The first thing wrong with them, with the bound.
    pub fn decode(bytes: &[u8]) -> Result<Self, WireError> {
        if envelope::is(MessageKind::SpecimenResult, bytes) {
            return Ok(Self::Measured(Box::new(SpecimenResult::decode(bytes)?)));
        }
        if envelope::is(MessageKind::WindowResult, bytes) {
            return Ok(Self::Moved(Box::new(window::decode_outcome(bytes)?)));
        }
        let (header, slabs) = envelope::open::<VerdictHeader>(MessageKind::Verdict, bytes)?;
        let slabs = Slabs::new(slabs);
        match header {
            VerdictHeader::Old { counts, reactions, report } => {
                let mut fracture = decode_parts(counts, reactions, report.report(), slabs)?;
                // All that the geometric family made was sampled, before there were marks.
                if fracture.origins.is_empty() && fracture.report.solver == "geometric" {
                    let origin = FragmentOrigin::of_sampled(!fracture.is_intact());
                    fracture.origins = vec![origin; fracture.fragments.len()];
                }
                Ok(fracture.into())
            }
            VerdictHeader::Parts { counts, reactions, report } => {
                Ok(decode_parts(counts, reactions, report, slabs)?.into())
            }
            VerdictHeader::Deformed(shape) => {
                let deformation = Box::new(decode_deformed(shape, slabs)?);
                Ok(Self::Solved(SolveOutcome::Deformed(deformation)))
            }
            VerdictHeader::Refused { solver, text } => {
                slabs.end("a verdict")?;
                Ok(Self::Refused { solver, text })
            }
            VerdictHeader::Failed { solver, text } => {
                slabs.end("a verdict")?;
                Ok(Self::Failed { solver, text })
            }
        }
    }
}

fn check_reactions(reactions: &[f64]) -> Result<(), WireError> {
    let most = MAX_SUPPORTS as u64;
    codec::limit("a body's reactions", reactions.len() as u64, most)?;
    codec::finite("a body's reactions", reactions)
}

/// Appends how many corners each convex part has.
fn put_hull_sizes<'a>(
    slabs: &mut Vec<u8>,
    hulls: impl Iterator<Item = &'a Vec<Vec3>>,
) -> Result<(), WireError> {
    for hull in hulls {
        let corners = hull.len() as u64;
        codec::limit("a convex part's corners", corners, mesh::MAX_VERTICES)?;
        mesh::put_u32s(slabs, [hull.len() as u32]);
    }
    Ok(())
}

fn encode_parts(body: &Fragmentation) -> Result<Vec<u8>, WireError> {
    let count = body.fragments.len();
    codec::limit("a body's fragments", count as u64, MAX_FRAGMENTS as u64)?;
    codec::limit("a body's grains", body.debris.len() as u64, MAX_GRAINS as u64)?;
    check_reactions(&body.reactions)?;
    let hulls = body.fragments.iter().map(|f| f.hulls.len()).sum::<usize>();
    let counts = PartCounts {
        fragments: count as u32,
        hulls: hulls as u32,
        grains: body.debris.len() as u32,
    };
    let (reactions, report) = (body.reactions.clone(), cut_report(&body.report));
    let head = VerdictHeader::Parts { counts, reactions, report };
    let mut slabs = Vec::new();
    for fragment in &body.fragments {
        let (nv, nt) = mesh::counts(&fragment.solid)?;
        let nh = fragment.hulls.len();
        codec::limit("a fragment's convex parts", nh as u64, MAX_HULLS as u64)?;
        let (sv, st) = mesh::sheet_counts(&fragment.sheet)?;
        mesh::put_u32s(&mut slabs, [nv, nt, sv, st, nh as u32]);
    }
    put_hull_sizes(&mut slabs, body.fragments.iter().flat_map(|f| &f.hulls))?;
    for fragment in &body.fragments {
        mesh::put_points(&mut slabs, &[fragment.velocity, fragment.spin]);
        mesh::put_solid(&mut slabs, &fragment.solid);
        mesh::put_sheet(&mut slabs, &fragment.sheet);
        fragment.hulls.iter().for_each(|hull| mesh::put_points(&mut slabs, hull));
    }
    for grain in &body.debris {
        mesh::put_points(&mut slabs, &[grain.position, grain.velocity]);
        slabs.extend_from_slice(&grain.volume.to_le_bytes());
        slabs.extend_from_slice(&grain.size.to_le_bytes());
    }
    if !body.origins.is_empty() {
        let (what, have, need) = ("a body's marks", body.origins.len(), count);
        if have != need {
            return Err(WireError::Short { what, have, need });
        }
        slabs.extend(body.origins.iter().map(|&origin| origin as u8));
    }
    envelope::seal(MessageKind::Verdict, &head, &slabs)
}

fn decode_parts(
    counts: PartCounts,
    reactions: Vec<f64>,
    report: Report,
    mut slabs: Slabs<'_>,
) -> Result<Fragmentation, WireError> {
    let PartCounts { fragments, hulls, grains } = counts;
    codec::limit("a body's fragments", u64::from(fragments), MAX_FRAGMENTS as u64)?;
    codec::limit("a body's grains", u64::from(grains), MAX_GRAINS as u64)?;
    check_reactions(&reactions)?;
    check_report(&report)?;
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
    let debris = bytes.as_chunks::<GRAIN>().0.iter().map(grain);
    let debris = debris.collect::<Result<_, _>>()?;
    let origins = match slabs.is_empty() {
        true => Vec::new(),
        false => origins_of(slabs.take("a body's marks", fragments.len(), 1)?)?,
    };
    slabs.end("a verdict")?;
    Ok(Fragmentation { fragments, origins, debris, reactions, report })
}

fn encode_deformed(deformation: &Deformation) -> Result<Vec<u8>, WireError> {
    let BodyShape::Solid(solid) = &deformation.body else {
        let kind = deformation.body.kind();
        return Err(WireError::Unknown { what: "a deformed body", kind });
    };
    let (vertices, triangles) = mesh::counts(solid)?;
    let hulls = deformation.hulls.len();
    codec::limit("a body's convex parts", hulls as u64, MAX_HULLS as u64)?;
    let shape = DeformedHeader {
        vertices,
        triangles,
        hulls: hulls as u32,
        velocity: deformation.velocity.into(),
        spin: deformation.spin.into(),
        work: deformation.work,
        reactions: deformation.reactions.clone(),
        report: cut_report(&deformation.report),
    };
    shape.check()?;
    let mut slabs = Vec::new();
    put_hull_sizes(&mut slabs, deformation.hulls.iter())?;
    mesh::put_solid(&mut slabs, solid);
    deformation.hulls.iter().for_each(|hull| mesh::put_points(&mut slabs, hull));
    envelope::seal(MessageKind::Verdict, &VerdictHeader::Deformed(shape), &slabs)
}

fn decode_deformed(shape: DeformedHeader, mut slabs: Slabs<'_>) -> Result<Deformation, WireError> {
    shape.check()?;
    let sizes = slabs.u32s("a body's convex parts", shape.hulls as usize)?;
    let solid = slabs.solid(shape.vertices, shape.triangles)?;
    let hulls = sizes.into_iter().map(|n| slabs.points("a convex part's corners", n as usize));
    let hulls = hulls.collect::<Result<_, _>>()?;
    slabs.end("a verdict")?;
    Ok(Deformation {
        body: solid.into(),
        hulls,
        velocity: shape.velocity.into(),
        spin: shape.spin.into(),
        work: shape.work,
        reactions: shape.reactions,
        report: shape.report,
    })
}

impl DeformedHeader {
    fn check(&self) -> Result<(), WireError> {
        codec::limit("a body's convex parts", u64::from(self.hulls), MAX_HULLS as u64)?;
        let motion = [self.velocity, self.spin];
        codec::finite("a deformed body's motion", motion.as_flattened())?;
        codec::finite("the work of a deformation", &[self.work])?;
        check_reactions(&self.reactions)?;
        check_report(&self.report)
    }
}

/// Bytes of which each says where a fragment comes from; 2 came with direction.
fn origins_of(bytes: &[u8]) -> Result<Vec<FragmentOrigin>, WireError> {
    let most = bytes.iter().copied().max().unwrap_or(0);
    codec::limit("a mark of a fragment", u64::from(most), 2)?;
    let origin = |mark: &u8| match mark {
        0 => FragmentOrigin::Solved,
        1 => FragmentOrigin::Sampled,
        _ => FragmentOrigin::Directed,
    };
    Ok(bytes.iter().map(origin).collect())
}

fn grain(row: &[u8; GRAIN]) -> Result<Grain, WireError> {
    let number = |k: usize| f64::from_le_bytes(row.as_chunks::<8>().0[k]);
    let numbers: [f64; 8] = std::array::from_fn(number);
    codec::finite("a body's grains", &numbers)?;
    let [x, y, z, u, v, w, volume, size] = numbers;
    let (position, velocity) = (Vec3::new(x, y, z), Vec3::new(u, v, w));
    Ok(Grain { position, velocity, volume, size })
}

fn check_report(report: &Report) -> Result<(), WireError> {
    let numbers = [
        report.spacing,
        report.simulated,
        report.crack_area,
        report.fracture_energy,
        report.dissipated_energy,
    ];
    codec::finite("a report's numbers", &numbers)?;
    let details: Vec<f64> = report.details.iter().map(|figure| figure.value).collect();
    codec::limit("a report's details", details.len() as u64, MAX_DETAILS as u64)?;
    codec::finite("a report's details", &details)?;
    let warnings = report.warnings.len() as u64;
    codec::limit("a report's warnings", warnings, MAX_WARNINGS as u64)
}

/// The report with its texts and lists cut to their limits.
fn cut_report(report: &Report) -> Report {
    let mut warnings: Vec<_> = report.warnings.iter().take(MAX_WARNINGS).map(|w| cut(w)).collect();
    let more = report.warnings.len().saturating_sub(MAX_WARNINGS);
    if let Some(last) = warnings.last_mut().filter(|_| more > 0) {
        *last = format!("{} more warnings", more + 1);
    }
    let refusal = report.refusal.as_deref().map(cut);
    let short = |text: &str| text[..text.floor_char_boundary(MAX_NAME)].to_owned();
    let detail = |one: &Figure| Figure { name: short(&one.name), unit: short(&one.unit), ..*one };
    let details = report.details.iter().take(MAX_DETAILS).map(detail).collect();
    Report { solver: cut(&report.solver), refusal, warnings, details, ..report.clone() }
}

#[cfg(test)]
mod tests;
