//! Bodies of a scene that move as they deform, ready for their windows.

use super::body::BodyTemplate;
use super::context::ResolveContext;
use super::format::{Air, BodyPart, Coupling, Dynamics, GripPlace, SoftGrip, WavePace};
use super::material::SceneMaterial;
use cullet_document::tree::{Path, join};
use cullet_geometry::{Pose, Vec3};
use cullet_model::{
    BodyCut, BodyGrip, BodyRegion, BondedSolid, ContinuumBody, MembranePace, SheetAir, SoftBody,
    SoftLaw,
};
use cullet_plan::family;
use std::sync::Arc;

/// Steps of the rigid world in a window.
pub(super) const WINDOW: u32 = 4;
/// Share of critical damping of the fastest motion \[1\].
pub(super) const DAMPING: f64 = 0.1;
/// Longer than any run \[s\].
pub(super) const LONGEST: f64 = 601.0;
/// The distance of points over the longest side of a body's box: of a shell, of a solid \[1\].
const SPACINGS: [f64; 2] = [1.0 / 40.0, 1.0 / 24.0];

/// What the solver of a soft body stands for.
struct SoftChoice {
    law: SoftLaw,
    /// The distance of its points over the longest side of its box, where the scene gives none.
    share: f64,
    /// How much coarser a draft is.
    coarser: f64,
}

/// A body of a scene that moves as it deforms: a sheet, a soft shell or a soft solid.
#[derive(Clone, Debug)]
pub struct SceneMovingBody {
    /// What the scene calls it.
    pub name: String,
    /// What it is made of.
    pub material: Arc<SceneMaterial>,
    /// What it is.
    pub body: ContinuumBody,
    /// Steps of the rigid world in a window.
    pub window: u32,
    /// Whether rigid bodies feel it.
    pub two_way: bool,
    /// Whether pieces of it that come to rest become rigid bodies.
    pub retire: bool,
}

impl SceneMovingBody {
    /// What it is, in words.
    #[must_use]
    pub fn about(&self) -> String {
        match &self.body {
            ContinuumBody::Membrane(sheet) => {
                let (thickness, spacing) = (sheet.thickness, sheet.spacing);
                format!("a sheet {thickness} m thick, points {spacing} m apart")
            }
            ContinuumBody::Soft(body) => {
                let kind = match body.law {
                    SoftLaw::Shell { .. } => "shell",
                    SoftLaw::Bonded(_) => "solid",
                };
                format!("a soft {kind}, points {} m apart", body.spacing)
            }
            _ => self.body.family().to_owned(),
        }
    }
}

impl ResolveContext<'_> {
    /// How fast waves run, as it is written.
    pub(super) fn pace(&mut self, written: WavePace, path: &Path) -> MembranePace {
        match (written.softer, written.heavier) {
            (None, None) => MembranePace::Real,
            (Some(speed), None) => MembranePace::Softer(speed),
            (None, Some(speed)) => MembranePace::Heavier(speed),
            (Some(_), Some(_)) => {
                self.wrong(&join(path, "pace"), "takes `softer` or `heavier`, one of them");
                MembranePace::Real
            }
        }
    }

    /// The rows of a grip's path, as it is written.
    pub(super) fn grip_rows(
        &mut self,
        velocity: Option<[f64; 3]>,
        places: &[GripPlace],
        path: &Path,
    ) -> Vec<(f64, Vec3)> {
        if velocity.is_some() && !places.is_empty() {
            self.wrong(path, "takes `velocity` or `path`, one of them");
        }
        if places.windows(2).any(|two| two[1].time <= two[0].time) {
            self.wrong(&join(path, "path"), "its times must rise");
        }
        match velocity {
            Some(velocity) => {
                vec![(0.0, Vec3::zeros()), (LONGEST, Vec3::from(velocity) * LONGEST)]
            }
            None => places.iter().map(|place| (place.time, place.offset.into())).collect(),
        }
    }

    /// Makes a dynamic body of its template; errors are noted, and `None` means that there were
    /// some.
    pub(super) fn dynamic(
        &mut self,
        written: &Dynamics,
        template: &BodyTemplate,
        (name, pose): (String, Pose),
        body: &Path,
    ) -> Option<SceneMovingBody> {
        let before = self.errors.len();
        let path = join(body, "dynamic");
        let material = &template.material;
        let SoftChoice { law, share, coarser } = self.soft_law(template, body)?;
        if template.fixed {
            self.wrong(&join(body, "fixed"), "a dynamic body moves: a `grip` holds it");
        }
        let origin = template.geometry.origin;
        let mut grips = Vec::new();
        for (index, grip) in written.grip.iter().enumerate() {
            let path = join(&join(&path, "grip"), index);
            grips.extend(self.soft_grip(grip, origin, &path));
        }
        let cuts = self.cuts(&written.cuts, origin, &path);
        let (low, high) = template.geometry.bounds;
        let pace = self.pace(written.pace, &path);
        let soft = SoftBody {
            solid: Arc::clone(&template.geometry.solid),
            material: material.solid(),
            law,
            spacing: template.spacing.unwrap_or(share * (high - low).amax()) * coarser,
            damping: written.damping.unwrap_or(DAMPING),
            pose,
            velocity: template.velocity,
            spin: template.spin,
            grips,
            cuts,
            air: air(written.air),
            pace,
        };
        let outside = |bound: &(_, f64, f64, f64)| !(bound.2..=bound.3).contains(&bound.1);
        for (what, value, low, high) in soft.bounds().into_iter().filter(outside) {
            let message = format!("{what} is {value:.3e}; it must lie in [{low:.3e}, {high:.3e}]");
            self.wrong(&path, message);
        }
        (self.errors.len() == before).then(|| SceneMovingBody {
            name,
            material: Arc::clone(material),
            body: ContinuumBody::Soft(soft),
            window: written.window.unwrap_or(WINDOW),
            two_way: written.coupling == Coupling::TwoWay,
            retire: written.retire,
        })
    }

    /// The law that the solver of a body stands for; that it stands for none is noted.
    fn soft_law(&mut self, template: &BodyTemplate, body: &Path) -> Option<SoftChoice> {
        let material = &template.material;
        let hardening = material.plasticity.map(|flow| flow.hardening);
        let fidelity = self.fidelity;
        match template.solver.name() {
            Some(family::SHELL) => {
                let law = SoftLaw::Shell { hardening, breaks: template.breakable };
                Some(SoftChoice { law, share: SPACINGS[0], coarser: fidelity.coarser_surface() })
            }
            Some(family::PERIDYNAMICS) => {
                let breaks = material.bonds.breaks && template.breakable;
                let law = SoftLaw::Bonded(BondedSolid { hardening, breaks, ..material.bonds });
                Some(SoftChoice { law, share: SPACINGS[1], coarser: fidelity.coarser_solid() })
            }
            _ => {
                let (shell, solid) = (family::SHELL, family::PERIDYNAMICS);
                let message = format!("a dynamic body has `solver` \"{shell}\" or \"{solid}\"");
                self.wrong(&join(body, "solver"), message);
                None
            }
        }
    }

    fn soft_grip(&mut self, grip: &SoftGrip, origin: Vec3, path: &Path) -> Option<BodyGrip> {
        let region = self.body_part(grip.region, origin, &join(path, "region"));
        let rows = self.grip_rows(grip.velocity, &grip.path, path);
        let turn = Vec3::from(grip.turn.unwrap_or_default());
        Some(BodyGrip { region: region?, path: rows, turn, until: grip.until })
    }

    pub(super) fn body_part(
        &mut self,
        part: BodyPart,
        origin: Vec3,
        path: &Path,
    ) -> Option<BodyRegion> {
        let place = |at: [f64; 3]| Vec3::from(at) + origin;
        match (part.low, part.high, part.centre, part.radius) {
            (Some(low), Some(high), None, None) if (0..3).all(|k| low[k] <= high[k]) => {
                Some(BodyRegion::Box { low: place(low), high: place(high) })
            }
            (Some(_), Some(_), None, None) => {
                self.wrong(path, "`low` must be at most `high`");
                None
            }
            (None, None, Some(centre), Some(radius)) => {
                Some(BodyRegion::Ball { centre: place(centre), radius })
            }
            _ => {
                self.wrong(path, "takes `low` and `high`, or `centre` and `radius`");
                None
            }
        }
    }

    fn cuts(&mut self, written: &[Vec<[f64; 3]>], origin: Vec3, path: &Path) -> Vec<BodyCut> {
        let mut cuts = Vec::new();
        for (index, corners) in written.iter().enumerate() {
            let corners: Vec<Vec3> = corners.iter().map(|at| Vec3::from(*at) + origin).collect();
            let first = corners.first().copied().unwrap_or_default();
            let spokes: Vec<Vec3> = corners.iter().skip(1).map(|at| at - first).collect();
            let normals = spokes.windows(2).map(|two| two[0].cross(&two[1]));
            let normal: Vec3 = normals.sum();
            let size = spokes.iter().map(nalgebra::Matrix::norm).fold(0.0, f64::max);
            let off = |spoke: &Vec3| spoke.dot(&normal).abs() > 1e-3 * size * normal.norm();
            if normal.norm() <= 1e-9 * size * size {
                let why = "has no area: give three corners or more that are not on a line";
                self.wrong(&join(&join(path, "cuts"), index), why);
            } else if spokes.iter().any(off) {
                self.wrong(&join(&join(path, "cuts"), index), "its corners do not lie in a plane");
            }
            cuts.push(BodyCut { corners });
        }
        cuts
    }
}

/// The air as it is written, or none.
pub(super) fn air(written: Option<Air>) -> SheetAir {
    let still = Air { density: 0.0, drag: 0.0, ..Air::default() };
    let air = written.unwrap_or(still);
    SheetAir {
        density: air.density,
        drag: air.drag,
        wind: Vec3::from(air.wind),
        gusts: [air.gusts, air.gust_rate],
        pressure: air.pressure,
    }
}
