//! From what a scene says of strength to the field that travels with a job.

use super::context::ResolveContext;
use super::direction::direction;
use super::format::{self, Body, Channel, Paint};
use super::geometry::BodyGeometry;
use super::material::SceneMaterial;
use super::score_line::ScoreLine;
use cullet_document::check::tell;
use cullet_document::files::key;
use cullet_document::tree::{Path, join};
use cullet_geometry::Vec3;
use cullet_model::strength::{Region, StrengthLayers, Stroke, VertexPaint, weakest_painted};
use cullet_model::{ArtDirection, BodyRegion, PatternWeakPlane, StrengthField};
use cullet_proto::strength::MAX_STROKES;
use std::sync::Arc;

/// Bounds of a painted factor \[1\].
pub(super) const FACTORS: (f64, f64) = (0.01, 100.0);

/// The strength field of a body.
pub(super) fn strength(
    context: &mut ResolveContext<'_>,
    body: &Body,
    path: &Path,
    material: &SceneMaterial,
    geometry: &BodyGeometry,
    direction: Option<&ArtDirection>,
) -> StrengthField {
    let mut field = StrengthField { offset: -geometry.origin, ..unpainted(material) };
    let (own, path) = (path, join(path, "paint"));
    for (index, paint) in body.paint.iter().enumerate() {
        let path = join(&path, index);
        if let Paint::Corners { .. } = paint {
            if field.vertices.is_some() {
                context.wrong(&path, "a second item paints the corners");
            }
            field.vertices = corners(context, (body, own), (paint, &path), geometry);
            continue;
        }
        if let Paint::Line { points, width, depth, factor } = paint {
            let line = ScoreLine { points, width: *width, depth: *depth, factor: *factor };
            let grooves = line.grooves(context, geometry, &path);
            field.strokes.extend(grooves);
            continue;
        }
        match stroke(paint) {
            Ok(stroke) => field.strokes.extend(stroke),
            Err((key, why)) => context.wrong(&join(&path, key), why),
        }
    }
    let strokes = field.strokes.len();
    let painted = body.paint.len().max(strokes);
    if painted > MAX_STROKES {
        let message = format!("at most {MAX_STROKES} items and pieces of lines; it has {painted}");
        context.wrong(&path, message);
    }
    let whole = direction.iter().flat_map(|direction| &direction.whole);
    field.strokes.extend(whole.map(|region| held(region, -geometry.origin)));
    if painted <= MAX_STROKES && field.strokes.len() > MAX_STROKES {
        let (most, whole) = (MAX_STROKES - strokes, field.strokes.len() - strokes);
        let beside = format!("beside {strokes} painted regions and pieces of lines");
        let message = format!("at most {most} {beside}; it has {whole}");
        context.wrong(&join(&join(own, "pieces"), "whole"), message);
    }
    field
}

fn corners(
    context: &mut ResolveContext<'_>,
    (body, own): (&Body, &Path),
    (paint, path): (&Paint, &Path),
    geometry: &BodyGeometry,
) -> Option<Arc<VertexPaint>> {
    let Paint::Corners { reach, channel, none, full, file } = paint else { return None };
    let Some(mesh) = &body.mesh else {
        context.wrong(path, "only a `mesh` has corners to paint");
        return None;
    };
    let base = |path: &Path| context.root.nearest(path).text.base.clone();
    let mesh = key(&base(&join(own, "mesh")), mesh);
    let base = base(&join(path, "file"));
    let bytes = context.files.get(&mesh).ok()?;
    let corners = cullet_assets::corners(&mesh, &bytes).ok()?;
    let factors = match file {
        Some(name) => match factors(context, &key(&base, name), corners.points.len()) {
            Ok(factors) => factors,
            Err(why) => {
                context.wrong(&join(path, "file"), why);
                return None;
            }
        },
        None if corners.colours.len() == corners.points.len() => {
            let slot = match channel {
                Channel::Red => 0,
                Channel::Green => 1,
                Channel::Blue => 2,
            };
            let mixed = |colour: &[f64; 3]| none + (full - none) * colour[slot];
            corners.colours.iter().map(mixed).collect()
        }
        None => {
            context.wrong(path, format!("{mesh} has no colours: name a `file` of factors"));
            return None;
        }
    };
    let points = corners.points.iter().map(|p| geometry.placed(p)).collect();
    Some(Arc::new(VertexPaint { points, factors, reach: *reach }))
}

/// What stays whole is as strong as paint can make it; `offset`: from the body's frame to the
/// pattern's \[m\].
fn held(region: &BodyRegion, offset: Vec3) -> Stroke {
    let region = match *region {
        BodyRegion::Ball { centre, radius } => Region::Sphere { centre: centre + offset, radius },
        BodyRegion::Box { low, high } => Region::Box { low: low + offset, high: high + offset },
    };
    Stroke { region, factor: FACTORS.1, edge: 0.0 }
}

/// One factor a line.
fn factors(context: &mut ResolveContext<'_>, file: &str, count: usize) -> Result<Vec<f64>, String> {
    let bytes = context.files.get(file).map_err(|error| error.to_string())?;
    let text = std::str::from_utf8(&bytes)
        .map_err(|error| format!("not UTF-8 text: byte {} is wrong", error.valid_up_to()))?;
    let (low, high) = FACTORS;
    let mut factors = Vec::new();
    for (line, word) in text.lines().enumerate().filter(|(_, word)| !word.trim().is_empty()) {
        let factor: Option<f64> = word.trim().parse().ok();
        match factor.filter(|factor| (low..=high).contains(factor)) {
            Some(factor) => factors.push(factor),
            None => {
                let (word, line) = (word.trim(), line + 1);
                let word: String = word.chars().take(40).collect();
                return Err(format!(
                    "line {line} must be a number in [{low}, {high}]; it is \"{word}\""
                ));
            }
        }
    }
    if factors.len() != count {
        let have = factors.len();
        return Err(format!("has {have} factors; the mesh file has {count} corners"));
    }
    Ok(factors)
}

/// The field of a body of a material that is not painted; the seed is the run's affair.
fn unpainted(material: &SceneMaterial) -> StrengthField {
    let plain = |normal| direction(normal).map_or(Vec3::z(), Vec3::from);
    let weak = |w: format::WeakPlane| PatternWeakPlane { normal: plain(w.normal), ratio: w.ratio };
    let layers = |l: format::Layers| StrengthLayers {
        normal: plain(l.normal),
        thickness: l.thickness,
        ratio: l.ratio,
        jitter: l.jitter,
    };
    StrengthField {
        weibull: material.weibull,
        correlation: material.correlation,
        weak_plane: material.weak_plane.map(weak),
        layers: material.layers.map(layers),
        ..StrengthField::even()
    }
}

/// A region; nothing where corners are painted.
fn stroke(paint: &Paint) -> Result<Option<Stroke>, (&'static str, String)> {
    let (region, factor, edge) = match *paint {
        Paint::Box { min, max, factor, edge } => {
            if let Some(axis) = (0..3).find(|&axis| min[axis] >= max[axis]) {
                let (low, high) = (tell(min[axis]), tell(max[axis]));
                let why =
                    format!("must be above `min` along each axis; {high} m is not above {low} m");
                return Err(("max", why));
            }
            (Region::Box { low: min.into(), high: max.into() }, factor, edge)
        }
        Paint::Sphere { centre, radius, factor, edge } => {
            (Region::Sphere { centre: centre.into(), radius }, factor, edge)
        }
        Paint::HalfSpace { point, normal, factor, edge } => {
            let normal = direction(normal).map_err(|why| ("normal", why.to_owned()))?;
            (Region::HalfSpace { point: point.into(), normal: normal.into() }, factor, edge)
        }
        Paint::Cylinder { from, to, radius, factor, edge } => {
            if from == to {
                return Err(("to", "must differ from `from`".to_owned()));
            }
            (Region::Cylinder { from: from.into(), to: to.into(), radius }, factor, edge)
        }
        Paint::Line { .. } | Paint::Corners { .. } => return Ok(None),
    };
    Ok(Some(Stroke { region, factor, edge }))
}

/// The least share of σ_f that the scene itself gave a part of a body \[1\]; flaws apart.
pub(super) fn weakest(field: &StrengthField) -> f64 {
    let painted = weakest_painted(&field.strokes);
    let corners = field.vertices.iter().flat_map(|paint| &paint.factors);
    let corner = corners.copied().fold(1.0, f64::min);
    let layers = field.layers.map_or(1.0, |layers| layers.ratio.min(1.0));
    let weak = field.weak_plane.map_or(1.0, |weak| weak.ratio);
    painted * corner * layers * weak
}

#[cfg(test)]
mod tests;
