//! The layout that a viewer opens a recording with: without one, new topics stay hidden and a run
//! shows as an empty grid.

use super::display::{UPRIGHT, WORLD};
use cullet_geometry::Vec3;
use serde_json::{Value, json};

/// A layout for Lichtblick and Foxglove that draws the objects of these topics, the log and two
/// plots, and looks at `centre` in the upright frame from as far as bodies within `radius` \[m\] of
/// it need.
pub(super) fn layout(objects: Vec<String>, centre: Vec3, radius: f64) -> String {
    let none = objects.is_empty();
    let drawn = objects.into_iter().map(|topic| (topic, json!({ "visible": true })));
    let mut topics: serde_json::Map<String, Value> = drawn.collect();
    // Where no object is drawn, the centres of the bodies are what there is to see.
    topics.insert("/fragments".to_owned(), json!({ "visible": none }));
    // The axes of a frame are a metre long, and would hide what is smaller.
    let no_axes = json!({ "visible": false });
    let frames = [UPRIGHT, WORLD].map(|frame| (format!("frame:{frame}"), no_axes.clone()));
    let frames: serde_json::Map<String, Value> = frames.into_iter().collect();
    let scene = json!({
        "cameraState": {
            "perspective": true, "distance": 4.0 * radius, "phi": 65, "thetaOffset": 40,
            "fovy": 40, "targetOffset": [centre.x, centre.y, centre.z], "target": [0, 0, 0],
            "targetOrientation": [0, 0, 0, 1], "near": 0.01 * radius, "far": 1e4 * radius
        },
        "followMode": "follow-none",
        "followTf": UPRIGHT,
        "scene": { "backgroundColor": "#d9dee4" },
        "transforms": frames,
        "topics": topics,
        "layers": {
            "grid": {
                "visible": true, "frameLocked": true, "label": "Grid", "instanceId": "grid",
                "layerId": "foxglove.Grid", "size": 10, "divisions": 10, "lineWidth": 1,
                "color": "#8f98a3ff", "position": [0, 0, 0], "rotation": [0, 0, 0], "order": 1
            }
        },
        "publish": {},
        "imageMode": {}
    });
    let layout = json!({
        "configById": {
            "3D!scene": scene,
            "RosOut!log": { "searchTerms": [], "minLogLevel": 1, "topicToRender": "/log" },
            "Plot!counts": plot("Pieces", &["bodies", "fragments", "fractures"]),
            "Plot!energy": plot("Energy [J]", &["translational_energy"]),
        },
        "globalVariables": {},
        "userNodes": {},
        "playbackConfig": { "speed": 0.5 },
        "layout": {
            "direction": "row",
            "first": "3D!scene",
            "second": {
                "direction": "column",
                "first": "RosOut!log",
                "second": {
                    "direction": "column", "first": "Plot!counts", "second": "Plot!energy",
                    "splitPercentage": 50
                },
                "splitPercentage": 40
            },
            "splitPercentage": 68
        }
    });
    serde_json::to_string_pretty(&layout).unwrap_or_default()
}

fn plot(title: &str, fields: &[&str]) -> Value {
    let path = |field: &&str| {
        json!({
            "value": format!("{}.{field}", super::STATS), "label": field, "enabled": true,
            "timestampMethod": "receiveTime"
        })
    };
    json!({
        "lichtblickPanelTitle": title, "foxglovePanelTitle": title,
        "paths": fields.iter().map(path).collect::<Vec<_>>(),
        "showXAxisLabels": true, "showYAxisLabels": true, "showLegend": true,
        "legendDisplay": "floating", "showPlotValuesInLegend": true, "isSynced": true,
        "xAxisVal": "timestamp", "sidebarDimension": 240
    })
}
