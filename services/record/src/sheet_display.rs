//! Sheets as viewers draw them: a triangle list a frame.

use super::display::{WORLD, colour, quaternion, timestamp};
use super::palette::{self, Rgb};
use super::quantity_scale::QuantityScale;
use cullet_geometry::Quat;
use cullet_model::{MovingSurface, SurfaceFrame};
use foxglove::messages::{
    Color, Point3, Pose, SceneEntity, SceneEntityDeletion, SceneUpdate, TriangleListPrimitive,
    Vector3, scene_entity_deletion,
};
use std::sync::Arc;

/// A sheet at one step, to be drawn.
#[derive(Clone, Debug)]
pub(super) struct DrawnSheet {
    pub(super) surface: Arc<MovingSurface>,
    pub(super) frame: SurfaceFrame,
    /// Least and greatest value of the quantity so far.
    pub(super) span: (f32, f32),
}

impl DrawnSheet {
    /// The whole state of the sheet: everything of it before is deleted by the same message.
    pub(super) fn update(&self, (name, material): (&str, &str), log_time: u64) -> SceneUpdate {
        let (time, origin) = (timestamp(log_time), self.frame.origin);
        let position = Some(Vector3 { x: origin.x, y: origin.y, z: origin.z });
        let orientation = Some(quaternion(&Quat::identity()));
        let points = self.frame.offsets.iter().map(|&offset| {
            let [x, y, z] = offset.map(f64::from);
            Point3 { x, y, z }
        });
        let plain = palette::colours(material, name, 0).0;
        let triangles = TriangleListPrimitive {
            pose: Some(Pose { position, orientation }),
            points: points.collect(),
            color: Some(colour(plain)),
            colors: self.tints(plain),
            indices: self.surface.triangles.iter().flatten().copied().collect(),
        };
        let entity = SceneEntity {
            timestamp: Some(time),
            frame_id: WORLD.to_owned(),
            id: name.to_owned(),
            triangles: vec![triangles],
            ..SceneEntity::default()
        };
        let deletion = SceneEntityDeletion {
            timestamp: Some(time),
            r#type: scene_entity_deletion::Type::All as i32,
            id: String::new(),
        };
        SceneUpdate { deletions: vec![deletion], entities: vec![entity] }
    }

    /// The colour of each point; none where no quantity diffuses.
    fn tints(&self, plain: Rgb) -> Vec<Color> {
        let scale = QuantityScale::of(plain, self.span);
        let tint = |scale: &QuantityScale, value| scale.colour(scale.share(value));
        let one = |&value: &f32| colour(scale.as_ref().map_or(plain, |it| tint(it, value)));
        self.frame.quantity.iter().map(one).collect()
    }
}
