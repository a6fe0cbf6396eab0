//! From the tree to a job: every name looked up, every part made ready.

use super::format::{self, Document, Family, Fields, Points, Side};
use super::{Specimen, Subject, asked, watch};
use cullet_document::error::{SceneError, suggest};
use cullet_document::files::{Files, key};
use cullet_document::tree::{Node, Path, Step, show};
use cullet_geometry::boolean::Exact;
use cullet_geometry::{Pose, Quat, Solid, TriMesh, Vec3};
use cullet_proto::specimen as wire;
use cullet_proto::strength::Region;
use cullet_scene::context::ResolveContext;
use cullet_scene::format::{Axis, Precision};
use cullet_scene::geometry::GeometrySource;
use cullet_scene::{direction, shape};
use serde::Deserialize;
use std::collections::BTreeMap;

/// What a name of a region is used for: a side of the specimen has no depth for what acts on it,
/// and one spacing for what is read off points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Use {
    Surface,
    Points,
}

/// A document on its way to a job.
pub(super) struct SpecimenBuilder<'a> {
    pub(super) shop: ResolveContext<'a>,
    pub(super) bounds: (Vec3, Vec3),
    pub(super) spacing: f64,
    regions: BTreeMap<String, Vec<format::Part>>,
    /// Why the body cannot be made.
    flaws: Vec<String>,
}

/// Makes a specimen of a tree that was held against the schema, or says what is wrong.
pub(super) fn resolve(root: &Node, files: &mut Files) -> Result<Specimen, Vec<SceneError>> {
    let shop = ResolveContext::new(root, files);
    let document = match Document::deserialize(root.to_toml()) {
        Ok(document) => document,
        Err(error) => return Err(vec![SceneError::at(&root.origin, "", error.message().trim())]),
    };
    let none = (Vec3::zeros(), Vec3::zeros());
    let mut desk = SpecimenBuilder {
        shop,
        bounds: none,
        spacing: 1.0,
        regions: BTreeMap::new(),
        flaws: Vec::new(),
    };
    let specimen = desk.specimen(&document);
    match specimen.filter(|_| desk.shop.errors.is_empty()) {
        Some(specimen) => Ok(specimen),
        None => Err(desk.shop.errors),
    }
}

pub(super) fn path(names: &[&str]) -> Path {
    names.iter().map(|name| (*name).into()).collect()
}

/// The path of an item of a list.
pub(super) fn item(list: &str, index: usize) -> Path {
    vec![Step::from(list), Step::from(index)]
}

fn below(path: &[Step], name: &str) -> Path {
    let mut longer = path.to_vec();
    longer.push(name.into());
    longer
}

impl SpecimenBuilder<'_> {
    pub(super) fn wrong(&mut self, path: &[Step], message: impl Into<String>) {
        self.shop.wrong(path, message);
    }

    /// Notes that the body cannot be made: what is read is right, and a run can still be told of.
    fn flaw(&mut self, path: &[Step], message: impl std::fmt::Display) {
        self.flaws.push(format!("{}: {message}", show(path)));
    }

    fn specimen(&mut self, document: &Document) -> Option<Specimen> {
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
        let axis = |axis: Axis| match axis {
            Axis::X => 0,
            Axis::Y => 1,
            Axis::Z => 2,
        };
        let (material, strength) = material?;
        let setup = wire::Setup {
            turn: [turn.w, turn.i, turn.j, turn.k],
            shift: document.geometry.shift,
            bodies,
            material,
            zones,
            strength,
            patches: self.patches(document),
            notches: self.notches(document),
            symmetries: document.symmetry.iter().map(|s| (axis(s.axis), s.at)).collect(),
            stretch: document.geometry.displacement_gradient,
            starts: self.starts(document),
            holds,
            loads,
            probes: watched.probes,
            settings: settings(document),
            end: run.end.unwrap_or(1.0),
            samples: run.samples,
            frames: run.frames,
            colour: watch::colour(run.colour),
        };
        Some(Specimen {
            name: String::new(),
            description: document.description.clone(),
            solver: match solver.family {
                Family::Brittle => "brittle",
            },
            subject: Subject::Body(Box::new(wire::SpecimenJob {
                solid: Solid::outer(mesh),
                setup,
            })),
            probes: watched.names,
            speeds: watched.speeds,
            metrics: watched.metrics,
            expected: watched.expected,
            ends: run.ends,
            flaw: (!self.flaws.is_empty()).then(|| self.flaws.join("; ")),
            warnings: std::mem::take(&mut self.shop.warnings),
        })
    }

    /// All bodies in the specimen's frame, and the first triangle of each but the first.
    fn bodies(&mut self, document: &Document) -> (TriMesh, Vec<u32>) {
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
    fn mesh(&mut self, document: &Document) -> Option<TriMesh> {
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
                    up: geometry.up,
                    repair: geometry.repair,
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

    fn name_regions(&mut self, document: &Document) {
        for (index, region) in document.region.iter().enumerate() {
            let taken = region.name == "all" || Side::ALL.iter().any(|side| side.0 == region.name);
            if taken || self.regions.contains_key(&region.name) {
                let message = format!("\"{}\" is the name of another region", region.name);
                self.wrong(&below(&item("region", index), "name"), message);
            }
            for (k, part) in region.parts.iter().enumerate() {
                let format::Part::Box { min, max } = part else { continue };
                let mut at = below(&item("region", index), "parts");
                at.push(k.into());
                for (axis, (low, high)) in ["x", "y", "z"].iter().zip(min.iter().zip(max)) {
                    if low > high {
                        let message =
                            format!("`min` is above `max` along {axis}: {low} m, {high} m");
                        self.wrong(&at, message);
                    }
                }
            }
            self.regions.insert(region.name.clone(), region.parts.clone());
        }
    }

    /// The parts of space that a name stands for.
    pub(super) fn region(&mut self, name: &str, at: &[Step], used: Use) -> wire::Where {
        if name == "all" {
            return Vec::new();
        }
        if let Some(side) = Side::ALL.iter().find(|side| side.0 == name) {
            let depth = if used == Use::Points { self.spacing } else { 0.0 };
            return vec![self.face(side.1, depth)];
        }
        let Some(parts) = self.regions.get(name).cloned() else {
            let known: Vec<&str> = self.regions.keys().map(String::as_str).collect();
            let all = known.into_iter().chain(["all"]).chain(Side::ALL.map(|side| side.0));
            let advice = suggest(name, &all.collect::<Vec<_>>());
            let message = format!("there is no region \"{name}\"");
            self.shop.wrong_with(&below(at, "region"), message, advice);
            return Vec::new();
        };
        parts.iter().map(|part| self.part(part, at)).collect()
    }

    fn face(&self, side: Side, depth: f64) -> Region {
        let (axis, high) = side.axis();
        let (low, top) = self.bounds;
        let (mut point, mut normal) = ([0.0; 3], [0.0; 3]);
        point[axis] = if high { top[axis] - depth } else { low[axis] + depth };
        normal[axis] = if high { -1.0 } else { 1.0 };
        Region::HalfSpace(point, normal)
    }

    fn part(&mut self, part: &format::Part, at: &[Step]) -> Region {
        match part {
            format::Part::Box { min, max } => Region::Box(*min, *max),
            format::Part::Ball { centre, radius } => Region::Sphere(*centre, *radius),
            format::Part::HalfSpace { point, normal } => {
                Region::HalfSpace(*point, self.unit(*normal, at))
            }
            format::Part::Cylinder { from, to, radius } => Region::Cylinder(*from, *to, *radius),
            format::Part::Face { side, depth } => self.face(*side, *depth),
        }
    }

    /// A direction of length 1.
    pub(super) fn unit(&mut self, direction: [f64; 3], at: &[Step]) -> [f64; 3] {
        direction::direction(direction).unwrap_or_else(|why| {
            self.wrong(at, why);
            [1.0, 0.0, 0.0]
        })
    }

    fn patches(&mut self, document: &Document) -> Vec<wire::Patch> {
        let rows = document.patch.iter().enumerate();
        rows.map(|(index, patch)| wire::Patch {
            part: self.region(&patch.region, &item("patch", index), Use::Points),
            strength: patch.strength,
            damage: patch.damage,
        })
        .collect()
    }

    fn notches(&mut self, document: &Document) -> Vec<wire::Notch> {
        let rows = document.notch.iter().enumerate();
        rows.map(|(index, notch)| wire::Notch {
            point: notch.point,
            normal: self.unit(notch.normal, &below(&item("notch", index), "normal")),
            part: self.region(&notch.region, &item("notch", index), Use::Points),
        })
        .collect()
    }

    fn starts(&mut self, document: &Document) -> Vec<wire::Start> {
        let rows = document.start.iter().enumerate();
        rows.map(|(index, start)| {
            let [x, y, z] = start.spin;
            let spin = [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]];
            let entry = |i: usize, j: usize| start.gradient[i][j] + spin[i][j];
            wire::Start {
                part: self.region(&start.region, &item("start", index), Use::Points),
                velocity: start.velocity,
                gradient: [0, 1, 2].map(|i| [0, 1, 2].map(|j| entry(i, j))),
                centre: start.centre,
                noise: start.noise,
            }
        })
        .collect()
    }

    fn holds(&mut self, document: &Document) -> Vec<wire::Hold> {
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
            wire::Hold {
                part: self.region(&support.region, &at, Use::Surface),
                axes,
                velocity: support.velocity,
                gradient: support.gradient,
                centre: support.centre,
                course: self.course(&support.time, &at),
                until: support.until,
            }
        })
        .collect()
    }

    fn loads(&mut self, document: &Document) -> Vec<wire::Load> {
        let mut loads = Vec::new();
        for (index, load) in document.load.iter().enumerate() {
            let at = item("load", index);
            let pushes: Vec<wire::Push> = [
                load.traction.map(wire::Push::Traction),
                load.pressure.map(wire::Push::Pressure),
                load.force.map(wire::Push::Force),
                load.acceleration.map(wire::Push::Acceleration),
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
                wire::Push::Traction(_) | wire::Push::Pressure(_) => Use::Surface,
                wire::Push::Force(_) | wire::Push::Acceleration(_) => Use::Points,
            };
            let part = self.region(&load.region, &at, used);
            loads.push(wire::Load { part, push, course: self.course(&load.time, &at) });
        }
        loads
    }

    fn course(&mut self, course: &format::Course, at: &[Step]) -> wire::Course {
        let at = below(at, "time");
        match course {
            format::Course::Constant => wire::Course::Table(vec![(0.0, 1.0)]),
            &format::Course::Ramp { rise } => wire::Course::Table(vec![(0.0, 0.0), (rise, 1.0)]),
            &format::Course::Step { from, until } => {
                if until <= from {
                    self.wrong(&at, format!("`until` must be after {from} s; it is {until} s"));
                }
                let before = if from > 0.0 { vec![(0.0, 0.0), (from, 0.0)] } else { Vec::new() };
                let rows = before.into_iter().chain([(from, 1.0), (until, 1.0), (until, 0.0)]);
                wire::Course::Table(rows.collect())
            }
            &format::Course::HalfSine { from, duration } => wire::Course::HalfSine(from, duration),
            format::Course::Table { times, factors } => {
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
                wire::Course::Table(times.iter().copied().zip(factors.iter().copied()).collect())
            }
        }
    }
}

fn cut(mesh: &TriMesh, slot: &format::Slot, turn: Quat) -> Result<TriMesh, String> {
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

fn settings(document: &Document) -> wire::Settings {
    let s = &document.solver;
    wire::Settings {
        spacing: s.spacing.unwrap_or(1.0),
        step_factor: s.step_factor,
        per_cell: s.points_per_cell,
        rows: s.points == Points::Rows,
        single: s.precision == Precision::Single,
        welded: s.fields == Fields::Single,
        breaks: s.breaks,
        softening_length: s.softening_length,
        damping: s.damping,
        damped_until: s.damped_until,
        max_points: f64::from(s.max_points),
        max_steps: f64::from(s.max_steps),
        threads: s.threads,
        seed: s.seed,
        look: s.look,
    }
}
