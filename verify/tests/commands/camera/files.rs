//! Image files: other formats, damaged files, and images without a finger.

use super::*;

#[test]
fn bad_images_are_refused_and_nothing_is_written() {
    let folder = Folder::new();
    let (image, _) = image_of(&folder, "image.png", "80:2", &[]);
    let good = std::fs::read(&image).expect("the image");
    let black = DynamicImage::ImageRgb8(RgbImage::new(1600, 1400));
    let small = DynamicImage::ImageRgb8(RgbImage::new(16, 14));
    let everything: Vec<String> = (1..=25).map(|node| node.to_string()).collect();
    let everything: Vec<&str> = everything.iter().map(String::as_str).collect();
    let (hidden, _) = image_of(&folder, "hidden.png", "80:2", &[&["--hide"], &everything[..]].concat());
    // A header that states 60 000 x 60 000 pixels.
    let mut huge = good.clone();
    huge[16..24].copy_from_slice(&[0, 0, 0xea, 0x60, 0, 0, 0xea, 0x60]);
    for (name, bytes, expected) in [
        ("empty.png", Vec::new(), "expected an image, PNG or JPEG"),
        ("text.png", b"node,ux_mm\n".to_vec(), "expected an image, PNG or JPEG"),
        ("short.png", good[..good.len() / 2].to_vec(), "expected a whole image"),
        ("head.png", good[..40].to_vec(), "expected a whole image"),
        ("huge.png", huge, "expected a whole image"),
        ("small.png", encoded(&small, ImageFormat::Png), "expected an image of 1600 x 1400 px"),
        ("black.jpg", encoded(&black, ImageFormat::Jpeg), "found 0 of 23 markers"),
        ("hidden.png", std::fs::read(&hidden).expect("the image"), "found 0 of 23 markers"),
    ] {
        let path = folder.put(name, bytes);
        let out = folder.put("out.csv", "as before");
        for role in ["--image", "--rest"] {
            let other = if role == "--image" { vec![] } else { vec!["--image", &image] };
            let arguments = [&["locate", CAMERA, role, &path, "--out", &out], &other[..]].concat();
            let message = finray(&arguments).refused();
            if role == "--image" {
                assert_says(&message, &[name, expected]);
            }
            assert_says(&message, &[name]);
            assert_eq!(folder.read("out.csv"), "as before");
        }
    }
    assert_says(&finray(&["locate", CAMERA, "--image", "nowhere.png"]).refused(), &["nowhere.png", "cannot be read"]);
    assert_says(&finray(&["locate", PAPER, "--image", &image]).refused(), &["[camera]"]);
    assert_says(&finray(&["render", PAPER]).refused(), &["[camera]"]);
    assert_says(&finray(&["render", CAMERA, "--hide", "26"]).refused(), &["--hide", "1 to 25"]);
}

/// Image files with other colour formats give the same result.
#[test]
fn other_kinds_of_image_files_are_read() {
    let folder = Folder::new();
    let (image, shape) = image_of(&folder, "image.png", "80:2", &[]);
    let decoded = image::open(&image).expect("the image");
    for (name, bytes) in [
        ("16.png", encoded(&DynamicImage::ImageRgb16(decoded.to_rgb16()), ImageFormat::Png)),
        ("alpha.png", encoded(&DynamicImage::ImageRgba8(decoded.to_rgba8()), ImageFormat::Png)),
    ] {
        let path = folder.put(name, bytes);
        let located = Csv::of(&finray(&["locate", CAMERA, "--image", &path]).done());
        assert_eq!(located.rows.len(), 25, "{name}");
        assert_located(&located, name, &shape);
    }
    // Without colour, the markers cannot be distinguished from the background.
    let grey = folder.put("grey.png", encoded(&DynamicImage::ImageLuma8(decoded.to_luma8()), ImageFormat::Png));
    assert_says(&finray(&["locate", CAMERA, "--image", &grey]).refused(), &["found 0 of 23 markers"]);
}

/// A damaged image file never causes a panic; the command succeeds or ends with a message.
#[test]
fn damaged_images_do_no_harm() {
    use rand::{RngExt, SeedableRng};
    let folder = Folder::new();
    let (image, _) = image_of(&folder, "image.png", "80:2", &[]);
    let decoded = image::open(&image).expect("the image");
    let files = [std::fs::read(&image).expect("the image"), encoded(&decoded, ImageFormat::Jpeg)];
    let mut chance = rand_chacha::ChaCha8Rng::seed_from_u64(18);
    for number in 0..40 {
        let mut bytes = files[number % 2].clone();
        for _ in 0..chance.random_range(1..20) {
            // Half of the damage is in the header, which contains lengths and types.
            let end = if chance.random_bool(0.5) { 700 } else { bytes.len() };
            let at = chance.random_range(0..end.min(bytes.len()));
            bytes[at] = chance.random();
        }
        let path = folder.put("damaged", &bytes);
        let answer = finray(&["locate", CAMERA, "--image", &path]);
        if answer.code != Some(0) {
            answer.refused();
        }
    }
}

/// The bytes of an EXIF block that contains only an orientation.
fn exif(orientation: u8) -> Vec<u8> {
    [b"MM\0*\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0".as_slice(), &[orientation, 0, 0, 0, 0, 0, 0]].concat()
}

/// A PNG file with an EXIF chunk before or after the pixels.
fn png_with_exif(png: &[u8], exif: &[u8], is_before: bool) -> Vec<u8> {
    let data = [b"eXIf", exif].concat();
    // The checksum of the chunk: CRC-32.
    let sum = data.iter().fold(u32::MAX, |sum, byte| {
        (0..8).fold(sum ^ u32::from(*byte), |sum, _| (sum >> 1) ^ if sum & 1 == 1 { 0xedb8_8320 } else { 0 })
    });
    let chunk = [&(exif.len() as u32).to_be_bytes(), data.as_slice(), &(!sum).to_be_bytes()].concat();
    // The first chunk ends after 33 bytes; the last chunk has 12 bytes.
    let at = if is_before { 33 } else { png.len() - 12 };
    [&png[..at], &chunk, &png[at..]].concat()
}

/// Viewers rotate an image according to its EXIF orientation. `locate` once ignored the orientation and assigned markers to wrong nodes.
#[test]
fn an_orientation_in_exif_is_not_heeded() {
    let folder = Folder::new();
    let (image, shape) = image_of(&folder, "image.png", "80:2", &[]);
    let upright = image::open(&image).expect("the image");
    let upside_down = encoded(&upright.rotate180(), ImageFormat::Png);
    let jpeg = encoded(&upright.rotate180(), ImageFormat::Jpeg);
    let block = [b"Exif\0\0", exif(3).as_slice()].concat();
    let segment = [&[0xff, 0xe1], &(block.len() as u16 + 2).to_be_bytes()[..], &block].concat();
    for (name, bytes) in [
        ("before.png", png_with_exif(&upside_down, &exif(3), true)),
        ("behind.png", png_with_exif(&upside_down, &exif(3), false)),
        ("left.png", png_with_exif(&encoded(&upright.rotate270(), ImageFormat::Png), &exif(6), true)),
        ("turned.jpg", [&jpeg[..2], &segment, &jpeg[2..]].concat()),
    ] {
        let located = Csv::of(&finray(&["locate", CAMERA, "--image", &folder.put(name, bytes)]).done());
        assert_eq!(located.rows.len(), 25, "{name}");
        if name.ends_with("png") {
            assert_located(&located, name, &shape);
        }
    }
    let plain = folder.put("plain.png", upside_down);
    assert_says(&finray(&["locate", CAMERA, "--image", &plain]).refused(), &["plain.png", "upside down", "EXIF"]);
    let left = folder.put("left.png", encoded(&upright.rotate270(), ImageFormat::Png));
    assert_says(&finray(&["locate", CAMERA, "--image", &left]).refused(), &["1400 x 1600 px", "turned by 90 degrees"]);
}
