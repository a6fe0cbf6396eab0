//! Tables (CSV): bodies, and where they are at each frame. Up is z.

use crate::timeline::{BodyTrack, ExportTimeline, Scenery};
use cullet_files::cells::quote_cell;
use cullet_record::FragmentOrigin;
use std::fmt::Write;

/// Both tables.
pub(crate) struct ExportTables {
    pub(crate) bodies: String,
    pub(crate) poses: String,
    pub(crate) count: usize,
    /// Rows of poses.
    pub(crate) rows: usize,
}

const BODIES: &str = "name,id,object,parent,generation,material,fixed,sampled,directed,mass_kg,\
volume_m3,birth_s,end_s,rest_x_m,rest_y_m,rest_z_m,rest_qx,rest_qy,rest_qz,rest_qw,\
damage_time_min_s,damage_time_max_s\n";

const POSES: &str = "name,id,frame,time_s,x_m,y_m,z_m,qx,qy,qz,qw,vx_m_s,vy_m_s,vz_m_s,\
wx_rad_s,wy_rad_s,wz_rad_s\n";

/// A value that is not always known.
fn known<T: ToString>(value: Option<T>) -> String {
    value.map_or_else(String::new, |value| value.to_string())
}

/// A row for each of these bodies.
pub(crate) fn of_bodies(timeline: &ExportTimeline, bodies: &[&BodyTrack]) -> String {
    let mut text = BODIES.to_owned();
    for track in bodies {
        let (body, range) = (&track.body, &timeline.range);
        let (place, turn) = (track.rest.translation, track.rest.rotation);
        let damage = timeline.mesh(track).damage_range();
        let end = Some(track.death).filter(|death| death.is_finite());
        let numbers = [place.x, place.y, place.z, turn.i, turn.j, turn.k, turn.w];
        let rest: Vec<String> = numbers.iter().map(f64::to_string).collect();
        let row = [
            quote_cell(&track.name),
            body.id.to_string(),
            quote_cell(&body.object),
            known(body.parent),
            body.generation.to_string(),
            quote_cell(&body.material),
            body.fixed.to_string(),
            known(track.is_of(FragmentOrigin::Sampled)),
            known(track.is_of(FragmentOrigin::Directed)),
            body.mass.to_string(),
            body.volume.to_string(),
            range.since(track.birth).to_string(),
            known(end.map(|end| range.since(end))),
            rest.join(","),
            known(damage.map(|range| range[0])),
            known(damage.map(|range| range[1])),
        ];
        text.push_str(&row.join(","));
        text.push('\n');
    }
    text
}

pub(crate) fn write(timeline: &ExportTimeline, scenery: Scenery) -> ExportTables {
    let range = &timeline.range;
    let times: Vec<f64> = match scenery {
        Scenery::Moment(time) => vec![time],
        Scenery::Motion | Scenery::Rest => {
            (0..range.frames()).map(|frame| range.start + frame as f64 / range.fps).collect()
        }
    };
    let there = |track: &&BodyTrack| match scenery {
        Scenery::Moment(time) => track.is_there(time),
        Scenery::Motion | Scenery::Rest => true,
    };
    let bodies: Vec<&BodyTrack> = timeline.bodies.iter().filter(there).collect();
    let (mut poses, mut rows) = (POSES.to_owned(), 0);
    for (frame, &time) in times.iter().enumerate() {
        for track in bodies.iter().filter(|track| track.is_there(time)) {
            let row = track.at(time, range);
            let (p, q) = (row.pose.translation.vector, row.pose.rotation);
            let (v, w) = (row.velocity, row.spin);
            let name = quote_cell(&track.name);
            let _ = write!(poses, "{name},{},{frame},{}", track.body.id, range.since(time));
            for number in [p.x, p.y, p.z, q.i, q.j, q.k, q.w, v.x, v.y, v.z, w.x, w.y, w.z] {
                let _ = write!(poses, ",{number}");
            }
            poses.push('\n');
            rows += 1;
        }
    }
    ExportTables { bodies: of_bodies(timeline, &bodies), poses, count: bodies.len(), rows }
}
