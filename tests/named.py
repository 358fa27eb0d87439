"""XMP with named faces, as other programs write it. Places: middle and size, in shares."""

import numpy as np

HEAD = (
    '<x:xmpmeta xmlns:x="adobe:ns:meta/"><rdf:RDF '
    'xmlns:rdf="http://www.w3.org/1999/02/22-rdf-syntax-ns#"><rdf:Description '
    'xmlns:mwg-rs="http://www.metadataworkinggroup.com/schemas/regions/" '
    'xmlns:stArea="http://ns.adobe.com/xmp/sType/Area#" '
    'xmlns:stDim="http://ns.adobe.com/xap/1.0/sType/Dimensions#" '
    'xmlns:MP="http://ns.microsoft.com/photo/1.2/" '
    'xmlns:MPRI="http://ns.microsoft.com/photo/1.2/t/RegionInfo#" '
    'xmlns:MPReg="http://ns.microsoft.com/photo/1.2/t/Region#">{}'
    "</rdf:Description></rdf:RDF></x:xmpmeta>"
)


def mwg(named, size, kind="Face", as_elements=False):
    """Regions as Lightroom writes them, in attributes; or as ExifTool does, in elements."""
    items = ""
    for name, ((x, y), (w, h)) in named:
        if as_elements:
            area = "".join(
                f"<stArea:{key}>{value}</stArea:{key}>"
                for key, value in zip("xywh", (x, y, w, h), strict=True)
            )
            items += (
                f'<rdf:li rdf:parseType="Resource"><mwg-rs:Area rdf:parseType="Resource">{area}'
                f"</mwg-rs:Area><mwg-rs:Name>{name}</mwg-rs:Name><mwg-rs:Type>{kind}"
                "</mwg-rs:Type></rdf:li>"
            )
        else:
            items += (
                f'<rdf:li><rdf:Description mwg-rs:Name="{name}" mwg-rs:Type="{kind}"><mwg-rs:Area '
                f'stArea:x="{x}" stArea:y="{y}" stArea:w="{w}" stArea:h="{h}"/>'
                "</rdf:Description></rdf:li>"
            )
    return (
        '<mwg-rs:Regions rdf:parseType="Resource"><mwg-rs:AppliedToDimensions '
        f'stDim:w="{size[0]}" stDim:h="{size[1]}"/><mwg-rs:RegionList><rdf:Bag>{items}'
        "</rdf:Bag></mwg-rs:RegionList></mwg-rs:Regions>"
    )


def microsoft(named):
    items = "".join(
        f'<rdf:li MPReg:PersonDisplayName="{name}" '
        f'MPReg:Rectangle="{x - w / 2}, {y - h / 2}, {w}, {h}"/>'
        for name, ((x, y), (w, h)) in named
    )
    return (
        '<MP:RegionInfo rdf:parseType="Resource"><MPRI:Regions><rdf:Bag>'
        f"{items}</rdf:Bag></MPRI:Regions></MP:RegionInfo>"
    )


def head_of(face, size):
    """Middle and size of a head in shares of the upright photo, as a program draws it."""
    x, y, width, height = face.box
    middle = np.array([x + width / 2, y + 0.2 * height]) / size
    return middle, np.array([1.1 * width, 1.6 * height]) / size
