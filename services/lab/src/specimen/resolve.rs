//! From the tree to a job: every name looked up, every part made ready.

use super::builder::{SpecimenBuilder, Use};
use super::format::{self, Fields, Points, SpecimenDocument};
use super::paths::{below, item, path};
use super::subject::{Specimen, Subject};
use super::{asked, watch};
use cullet_document::error::SceneError;
use cullet_document::files::{Files, key};
use cullet_document::tree::{Node, Step};
use cullet_geometry::boolean::Exact;
use cullet_geometry::{Mat3, Pose, Quat, Solid, TriMesh, Vec3};
use cullet_model::{Hardening, JohnsonCook, PointPrecision, StrengthField};
use cullet_proto::specimen::SpecimenJob;
use cullet_scene::format::{Axis, Precision as WrittenPrecision};
use cullet_scene::geometry::GeometrySource;
use cullet_scene::material::SceneMaterial;
use cullet_scene::shape;
use cullet_specimen as core;
use serde::Deserialize;

/// Makes a specimen of a tree that was checked against the schema, or says what is wrong.
pub(super) fn resolve(root: &Node, files: &mut Files) -> Result<Specimen, Vec<SceneError>> {
    let document = match SpecimenDocument::deserialize(root.to_toml()) {
        Ok(document) => document,
        Err(error) => return Err(vec![SceneError::at(&root.origin, "", error.message().trim())]),
    };
    let mut desk = SpecimenBuilder::new(root, files);
    let specimen = desk.specimen(&document);
    match specimen.filter(|_| desk.shop.errors.is_empty()) {
        Some(specimen) => Ok(specimen),
        None => Err(desk.shop.errors),
    }
}

impl SpecimenBuilder<'_> {
    fn specimen(&mut self, document: &SpecimenDocument) -> Option<Specimen> {
        let (solver, run) = (&document.solver, &document.run);
        if solver.spacing.is_none() {
            self.wrong(&path(&["solver"]), "`spacing` is missing");
        }
        if run.end.is_none() {
            self.wrong(&path(&["run"]), "`end` is missing");
        }
        self.spacing = solver.spacing.unwrap_or(1.0);
        let (mesh, bodies) = self.bodies(document);
        self.bounds = mesh.bounds().unwrap_or_default();
        self.name_regions(document);
        let material = self.whole(document);
        let zones = self.zones(document);
        let turn =
            self.shop.rotation(&document.geometry.rotation, &path(&["geometry", "rotation"]));
        let supports = document.support.iter().map(|support| &*support.name);
        asked::named_once(&mut self.shop, "support", supports);
        asked::named_once(&mut self.shop, "load", document.load.iter().map(|load| &*load.name));
        let holds = self.holds(document);
        let loads = self.loads(document);
        let watched = watch::read(self, document);
        let matter = self.matter(document, zones, material?);
        let shift = Vec3::from(document.geometry.shift);
        let problem = core::SpecimenProblem {
            family: solver.family.clone(),
            body: core::SpecimenBody { mesh, parts: bodies, turn, shift },
            matter,
            initial: core::InitialState {
                stretch: matrix(&document.geometry.displacement_gradient),
                starts: self.starts(document),
                notches: self.notches(document),
            },
            holds,
            symmetries: document.symmetry.iter().map(plane).collect(),
            loads,
            output: core::Output {
                end: run.end.unwrap_or(1.0),
                probes: watched.probes,
                samples: run.samples,
                frames: run.frames,
                colour: watch::colour(run.colour),
            },
            settings: settings(document),
        };
        Some(Specimen {
            name: String::new(),
            description: document.description.clone(),
            solver: solver.family.clone(),
            subject: Subject::Body(Box::new(SpecimenJob(problem))),
            probes: watched.names,
            speeds: watched.speeds,
            metrics: watched.metrics,
            expected: watched.expected,
            ends: run.ends,
            flaw: (!self.flaws.is_empty()).then(|| self.flaws.join("; ")),
            warnings: std::mem::take(&mut self.shop.warnings),
        })
    }

    fn matter(
        &mut self,
        document: &SpecimenDocument,
        zones: Vec<core::Zone>,
        (material, yields, strength): (SceneMaterial, Option<Hardening>, StrengthField),
    ) -> core::Matter {
        let (flow, patches) = (yields.map(JohnsonCook::from), self.patches(document));
        let (material, surface) = (material.solid(), material.surface);
        core::Matter { material, surface, flow, zones, strength, patches }
    }

    /// All bodies in the specimen's frame, and the first triangle of each but the first.
    fn bodies(&mut self, document: &SpecimenDocument) -> (TriMesh, Vec<u32>) {
        let mut mesh = self.mesh(document).unwrap_or_default();
        let mut starts = Vec::new();
        for (index, body) in document.body.iter().enumerate() {
            let at = item("body", index);
            let turn = self.shop.rotation(&body.rotation, &below(&at, "rotation"));
            let pose = Pose::from_parts(Vec3::from(body.position).into(), turn);
            match shape::mesh(&body.shape) {
                Ok(other) => {
                    starts.push(mesh.triangles.len() as u32);
                    mesh.append(&other.transformed(&pose));
                }
                Err(why) => self.flaw(&below(&at, "shape"), why),
            }
        }
        (mesh, starts)
    }

    /// The body with its slots cut out, in the specimen's frame.
    fn mesh(&mut self, document: &SpecimenDocument) -> Option<TriMesh> {
        let geometry = &document.geometry;
        let at = path(&["geometry"]);
        let mesh = match (&geometry.shape, &geometry.mesh) {
            (Some(_), Some(_)) | (None, None) => {
                self.wrong(&at, "takes `shape` or `mesh`, one of them");
                return None;
            }
            (Some(shape), None) => shape::mesh(shape),
            (None, Some(file)) => {
                let written = below(&at, "mesh");
                let key = key(&self.shop.root.nearest(&written).text.base, file);
                if !self.shop.has_mesh(&key, &written) {
                    return None;
                }
                let recipe = GeometrySource::Mesh {
                    key,
                    fit: geometry.fit,
                    scale: geometry.scale,
                    thickness: None,
                    up: geometry.up,
                    repair: geometry.repair,
                    object: None,
                };
                let form = self.shop.geometries.get(&recipe, self.shop.files);
                form.map(|form| form.solid.mesh.translated(-form.origin))
            }
        };
        let mut mesh = match mesh {
            Ok(mesh) => mesh.translated(Vec3::from(geometry.position)),
            Err(why) => {
                self.flaw(&at, why);
                return None;
            }
        };
        for (index, slot) in document.slot.iter().enumerate() {
            let at = item("slot", index);
            let turn = self.shop.rotation(&slot.rotation, &below(&at, "rotation"));
            match cut(&mesh, slot, turn) {
                Ok(rest) => mesh = rest,
                Err(why) => self.flaw(&at, why),
            }
        }
        Some(mesh)
    }

    fn patches(&mut self, document: &SpecimenDocument) -> Vec<core::StrengthPatch> {
        let rows = document.patch.iter().enumerate();
        rows.map(|(index, patch)| core::StrengthPatch {
            part: self.region(&patch.region, &item("patch", index), Use::Points),
            strength: patch.strength,
            damage: patch.damage,
        })
        .collect()
    }

    fn notches(&mut self, document: &SpecimenDocument) -> Vec<core::Notch> {
        let rows = document.notch.iter().enumerate();
        rows.map(|(index, notch)| core::Notch {
            point: Vec3::from(notch.point),
            normal: self.unit(notch.normal, &below(&item("notch", index), "normal")),
            part: self.region(&notch.region, &item("notch", index), Use::Points),
        })
        .collect()
    }

    fn starts(&mut self, document: &SpecimenDocument) -> Vec<core::Start> {
        let rows = document.start.iter().enumerate();
        rows.map(|(index, start)| {
            let spin = Vec3::from(start.spin).cross_matrix();
            core::Start {
                part: self.region(&start.region, &item("start", index), Use::Points),
                velocity: Vec3::from(start.velocity),
                gradient: matrix(&start.gradient) + spin,
                centre: Vec3::from(start.centre),
                noise: start.noise,
            }
        })
        .collect()
    }

    fn holds(&mut self, document: &SpecimenDocument) -> Vec<core::Hold> {
        let rows = document.support.iter().enumerate();
        rows.map(|(index, support)| {
            let at = item("support", index);
            let mut axes = [false; 3];
            for letter in support.axes.chars() {
                match "xyz".find(letter) {
                    Some(axis) => axes[axis] = true,
                    None => {
                        let message = format!("`{letter}` is no axis; known: x, y, z");
                        self.wrong(&below(&at, "axes"), message);
                    }
                }
            }
            core::Hold {
                part: self.region(&support.region, &at, Use::Surface),
                axes,
                velocity: Vec3::from(support.velocity),
                gradient: matrix(&support.gradient),
                centre: Vec3::from(support.centre),
                course: self.course(&support.time, &at),
                until: support.until,
            }
        })
        .collect()
    }

    fn loads(&mut self, document: &SpecimenDocument) -> Vec<core::Load> {
        let mut loads = Vec::new();
        for (index, load) in document.load.iter().enumerate() {
            let at = item("load", index);
            let pushes: Vec<core::LoadKind> = [
                load.traction.map(|v| core::LoadKind::Traction(Vec3::from(v))),
                load.pressure.map(core::LoadKind::Pressure),
                load.force.map(|v| core::LoadKind::Force(Vec3::from(v))),
                load.acceleration.map(|v| core::LoadKind::Acceleration(Vec3::from(v))),
            ]
            .into_iter()
            .flatten()
            .collect();
            let &[push] = pushes.as_slice() else {
                let keys = "`traction`, `pressure`, `force` or `acceleration`";
                self.wrong(&at, format!("takes {keys}, one of them; it has {}", pushes.len()));
                continue;
            };
            let used = match push {
                core::LoadKind::Traction(_) | core::LoadKind::Pressure(_) => Use::Surface,
                core::LoadKind::Force(_) | core::LoadKind::Acceleration(_) => Use::Points,
            };
            let part = self.region(&load.region, &at, used);
            loads.push(core::Load { part, push, course: self.course(&load.time, &at) });
        }
        loads
    }

    fn course(&mut self, course: &format::AmplitudeConfig, at: &[Step]) -> core::Amplitude {
        let at = below(at, "time");
        match course {
            format::AmplitudeConfig::Constant => core::Amplitude::Table(vec![(0.0, 1.0)]),
            &format::AmplitudeConfig::Ramp { rise } => {
                core::Amplitude::Table(vec![(0.0, 0.0), (rise, 1.0)])
            }
            &format::AmplitudeConfig::Step { from, until } => {
                if until <= from {
                    self.wrong(&at, format!("`until` must be after {from} s; it is {until} s"));
                }
                let before = if from > 0.0 { vec![(0.0, 0.0), (from, 0.0)] } else { Vec::new() };
                let rows = before.into_iter().chain([(from, 1.0), (until, 1.0), (until, 0.0)]);
                core::Amplitude::Table(rows.collect())
            }
            &format::AmplitudeConfig::HalfSine { from, duration } => {
                core::Amplitude::HalfSine { start: from, duration }
            }
            format::AmplitudeConfig::Table { times, factors } => {
                if times.len() != factors.len() {
                    let (a, b) = (times.len(), factors.len());
                    self.wrong(
                        &at,
                        format!("has {a} `times` and {b} `factors`; as many are needed"),
                    );
                }
                if let Some(pair) = times.windows(2).find(|pair| pair[1] < pair[0]) {
                    let message = format!("`times` must ascend; {} follows {}", pair[1], pair[0]);
                    self.wrong(&at, message);
                }
                core::Amplitude::Table(times.iter().copied().zip(factors.iter().copied()).collect())
            }
        }
    }
}

fn cut(mesh: &TriMesh, slot: &format::SlotConfig, turn: Quat) -> Result<TriMesh, String> {
    let pose = Pose::from_parts(Vec3::from(slot.position).into(), turn);
    let tool = shape::mesh(&slot.shape)?.transformed(&pose);
    let exact =
        |mesh: &TriMesh| Exact::new(&Solid::outer(mesh.clone())).map_err(|error| error.to_string());
    let rest = exact(mesh)?.subtract(&exact(&tool)?).map_err(|error| error.to_string())?;
    if rest.is_empty() {
        return Err("nothing is left of the specimen".to_owned());
    }
    Ok(rest.mesh())
}

/// A matrix by its rows.
fn matrix(rows: &[[f64; 3]; 3]) -> Mat3 {
    Mat3::from_fn(|i, j| rows[i][j])
}

fn plane(symmetry: &format::Symmetry) -> core::SymmetryPlane {
    let axis = match symmetry.axis {
        Axis::X => 0,
        Axis::Y => 1,
        Axis::Z => 2,
    };
    core::SymmetryPlane { axis, at: symmetry.at }
}

fn settings(document: &SpecimenDocument) -> core::SpecimenSettings {
    let s = &document.solver;
    core::SpecimenSettings {
        spacing: s.spacing.unwrap_or(1.0),
        step_factor: s.step_factor,
        precision: match s.precision {
            WrittenPrecision::Single => PointPrecision::Single,
            WrittenPrecision::Double => PointPrecision::Double,
        },
        breaks: s.breaks,
        damping: s.damping,
        damped_until: s.damped_until,
        max_points: f64::from(s.max_points),
        max_steps: f64::from(s.max_steps),
        threads: s.threads,
        seed: s.seed,
        points: core::PointSettings {
            per_cell: s.points_per_cell,
            layout: match s.points {
                Points::Scattered => core::PointLayout::Scattered,
                Points::Rows => core::PointLayout::Rows,
            },
            welded: s.fields == Fields::Single,
            softening_length: s.softening_length,
            look: s.look,
        },
        horizon: s.horizon,
    }
}
