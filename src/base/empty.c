typedef int lmn_empty;
