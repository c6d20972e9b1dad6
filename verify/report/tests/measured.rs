//! Marker residuals drawn over their image.

use finray_report::measured::picture::{magnified, svg};
use finray_studies::experiments::measured::picture::{Arrow, Picture};

/// An image of 2 px per mm, with one residual of half a pixel.
fn picture(jpeg: &[u8]) -> Picture {
    let arrow = Arrow { seen: [100.0, 50.0], residual_px: [0.3, -0.4] };
    Picture {
        image: "a\"<b>.jpg".to_owned(),
        size_px: [400, 200],
        jpeg: jpeg.to_vec(),
        px_a_mm: 2.0,
        arrows: vec![arrow],
    }
}

/// The test vectors of RFC 4648, sec. 10.
#[test]
fn bytes_are_encoded_as_the_standard_has_it() {
    for (bytes, text) in
        [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foob", "Zm9vYg=="), ("fooba", "Zm9vYmE=")]
    {
        let svg = svg(&picture(bytes.as_bytes()), 50.0);
        assert!(svg.contains(&format!("base64,{text}\"")), "{text} is not in {svg}");
    }
}

/// The longest residual is drawn with at most 48 px, and the scale bar fits into the picture.
#[test]
fn residuals_are_drawn_to_scale() {
    let picture = picture(&[255]);
    assert_eq!(magnified(std::slice::from_ref(&picture)), 50.0);
    let svg = svg(&picture, 50.0);
    for part in ["M100.0 50.0L115.0 30.0", ">1 mm</text>", "M20 180h100.0", "a&quot;&lt;b&gt;.jpg", "base64,/w==\""] {
        assert!(svg.contains(part), "{part} is not in {svg}");
    }
}
