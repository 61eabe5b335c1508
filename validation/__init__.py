"""Reports that judge the library against exact solutions, published figures and its peers."""
