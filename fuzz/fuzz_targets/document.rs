//! JSON documents: options of databases, trainings, segmentations and depth maps, optics, workcells, aliases, tracks. What
//! is taken must then be of use.
#![no_main]

use landmarkd_fuzz::service::{Answer, Call, send};
use landmarkd_fuzz::{drawn, seeds};
use libfuzzer_sys::fuzz_target;

const CALLS: [(&str, &str); 8] = [
    ("PUT", "/v1/databases/new"),
    ("PUT", "/v1/databases/lab"),
    ("PUT", "/v1/calibrations/new"),
    ("PUT", "/v1/workcells/new"),
    ("POST", "/v1/databases/lab/trainings"),
    ("POST", "/v1/databases/parts/trainings"),
    ("POST", "/v1/databases/lab/tracks"),
    ("PUT", "/v1/databases/lab/aliases/new"),
];

fn send_body(method: &str, target: &str, media_type: &str, body: &[u8]) -> Option<Answer> {
    let headers: [(&[u8], &[u8]); 1] = [(b"content-type", media_type.as_bytes())];
    send(Call { method, target, headers: &headers, body, piece_bytes: 0 })
}

fn send_form(target: &str, parts: &[(&str, &[u8])]) {
    send_body("POST", target, drawn::FORM, &drawn::form(parts));
}

fuzz_target!(init: seeds::write(seeds::documents), |bytes: &[u8]| {
    let [call, document @ ..] = bytes else { return };
    let (near, far) = (drawn::scene_png(1), drawn::scene_png(2));
    let optics = drawn::optics().to_string();
    match usize::from(*call) % (CALLS.len() + 4) {
        8 => send_form("/v1/depth-maps", &[("near", &near), ("far", &far), ("optics", document)]),
        9 => send_form(
            "/v1/depth-maps",
            &[("near", &near), ("far", &far), ("optics", optics.as_bytes()), ("options", document)],
        ),
        10 => send_form("/v1/segmentations", &[("image", &near), ("options", document)]),
        11 => send_form("/v1/calibrations/rig/sweep", &[("manifest", b"[]"), ("options", document)]),
        which => {
            let (method, target) = CALLS[which];
            let answer = send_body(method, target, "application/json", document);
            if answer.is_none_or(|answer| answer.status >= 300) {
                return;
            }
            match which {
                0 => {
                    for number in 0..2 {
                        let target = format!("/v1/databases/new/exemplars?label=l{number}&pose_deg={number}");
                        send_body("POST", &target, "image/png", &drawn::scene_png(number));
                    }
                    send_body("POST", "/v1/databases/new/trainings", "application/json", b"{}");
                    send_body("DELETE", "/v1/databases/new", "", b"");
                }
                2 => {
                    send_form("/v1/depth-maps", &[("near", &near), ("far", &far), ("calibration", b"new")]);
                    send_body("GET", "/v1/calibrations", "", b"");
                    send_body("DELETE", "/v1/calibrations/new", "", b"");
                }
                3 => {
                    send_form("/v1/workcells/new/inspections", &[("overview", &near)]);
                    send_body("POST", "/v1/workcells/new/centrings", "image/png", &near);
                    send_body("GET", "/v1/workcells", "", b"");
                    send_body("DELETE", "/v1/workcells/new", "", b"");
                }
                _ => {}
            }
        }
    }
});
