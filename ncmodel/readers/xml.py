"""XML documents without their namespaces."""

from xml.etree import ElementTree


def parsed(data: bytes) -> ElementTree.Element:
    """The root of a document; names of elements are without namespace.

    Raises:
        ValueError: It isn't well-formed; the text says where.
    """
    try:
        root = ElementTree.fromstring(data)
    except ElementTree.ParseError as error:
        raise ValueError(f"XML that breaks off or is damaged ({error})") from error
    for element in root.iter():
        element.tag = element.tag.rpartition("}")[2]
    return root
